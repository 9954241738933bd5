/* SPDX-License-Identifier: MIT */
// Observer of the stator flux linkage in the stationary frame, corrected by the known magnitude of
// the rotor's flux [Lee 2010, Ortega 2011], and a PLL on the direction of that flux:
//     dλ/dt = v − R·i + γ/2·η·(φ² − |η|²),  η = λ − L·i,  θ = arg η
// With saliency η is the active flux λ − L_q·i, and its magnitude φ + (L_d − L_q)·i_d [Boldea
// 2008].
//
// [Lee 2010] J. Lee, J. Hong, K. Nam, R. Ortega, L. Praly, A. Astolfi: Sensorless control of
// surface-mount permanent-magnet synchronous motors based on a nonlinear observer. IEEE Trans.
// Power Electron. 25 (2), 2010. [Ortega 2011] R. Ortega, L. Praly, A. Astolfi, J. Lee, K. Nam:
// Estimation of rotor position and speed of permanent magnet synchronous motors with guaranteed
// stability. IEEE Trans. Control Syst. Technol. 19 (3), 2011. [Boldea 2008] I. Boldea, M. C. Paicu,
// G.-D. Andreescu: Active flux concept for motion-sensorless unified AC drives. IEEE Trans. Power
// Electron. 23 (5), 2008.
#pragma once

#include "estimator.h"
#include "pll.h"

namespace nf::peers
{

class FluxObserver : public Estimator
{
public:
    // correction: γ·φ²·T, the share of an error of the magnitude that a sample takes away
    FluxObserver(double correction, const Pll &pll);

    void start(const Model &model, const Estimate &known, Complex current_a) override;
    Estimate step(const Model &model, const Sample &sample) override;
    void follow(const Model &model, const Estimate &known) override;

private:
    double correction_;
    Pll pll_;
    Complex flux_;    // λ
    Complex current_; // of the last sample
};

} // namespace nf::peers
