/* SPDX-License-Identifier: MIT */
/* Flux maps of saturated iron: what is stated of them, and what any map from an energy has. */
#include "iron.h"
#include "seeded.h"
#include "testing.h"

#include <math.h>

/* Of the currents: sums of some ten operations. */
#define ROUNDING 1.0e-13

/* Central differences over STEP of what bends over 1: STEP^2 / 6, and roundings over STEP. */
#define STEP 1.0e-4
#define DIFFERENCE 1.0e-8

static plant_iron_cfg_t cfg;
static plant_iron_t iron;

static double scale_d(void)
{
    return cfg.inductance_d_h * cfg.current_a;
}

static double scale_q(void)
{
    return cfg.inductance_q_h * cfg.current_a;
}

static plant_dq_t current_at(double flux_d, double flux_q)
{
    return plant_iron_current(&iron, (plant_dq_t){flux_d, flux_q});
}

static plant_dq_t flux_at(double i_d, double i_q)
{
    return plant_iron_flux(&iron, (plant_dq_t){i_d, i_q});
}

static void start(void)
{
    plant_iron_init(&iron, &cfg);
}

void setUp(void)
{
    cfg = (plant_iron_cfg_t){
        .inductance_d_h = 0.010,
        .inductance_q_h = 0.015,
        .current_a = 6.0,
        .fall_d = 0.2,
        .fall_q = 0.3,
        .shared = 0.8,
    };
    start();
}

/* Any motor that can be configured, with the ends of the ranges among them. */
static void start_any(seeded_t *seeded)
{
    const double ends[] = {0.0, 1.0};
    const double d = (double)seeded_in(seeded, 0, 1000) / 1000.0;
    const double q = (double)seeded_in(seeded, 0, 1000) / 1000.0;
    const double s = (double)seeded_in(seeded, 0, 1000) / 1000.0;
    const bool is_end = seeded_in(seeded, 0, 2) == 0;

    cfg.inductance_q_h = cfg.inductance_d_h * (double)seeded_in(seeded, 2, 40) / 10.0;
    cfg.fall_d = PLANT_IRON_FALL_D_MAX * (is_end ? ends[seeded_in(seeded, 0, 1)] : d);
    cfg.fall_q = PLANT_IRON_FALL_Q_MAX * (is_end ? ends[seeded_in(seeded, 0, 1)] : q);
    cfg.shared = plant_iron_shared_max(&cfg) * (is_end ? ends[seeded_in(seeded, 0, 1)] : s);
    start();
}

/* Some point of the plane, up to ten times rated current. */
static plant_dq_t any_current(seeded_t *seeded)
{
    const double size = 1.0e-4 * cfg.current_a * pow(10.0, seeded_in(seeded, 0, 5));

    return (plant_dq_t){size * 1.0e-3 * seeded_in(seeded, -1000, 1000),
                        size * 1.0e-3 * seeded_in(seeded, -1000, 1000)};
}

TEST(test_without_current_the_inductances_are_those_stated)
{
    const double small = 1.0e-6 * cfg.current_a; /* bends by 3 g_d of it at most, g_d < 1/3 */

    TEST_ASSERT_DOUBLE_WITHIN(1.0e-6 * cfg.inductance_d_h, cfg.inductance_d_h,
                              flux_at(small, 0.0).d / small);
    TEST_ASSERT_DOUBLE_WITHIN(1.0e-6 * cfg.inductance_q_h, cfg.inductance_q_h,
                              flux_at(0.0, small).q / small);
    TEST_ASSERT_TRUE(fabs(flux_at(0.0, 0.0).d) + fabs(flux_at(0.0, 0.0).q) <= 0.0);
}

TEST(test_at_the_stated_current_the_inductances_have_fallen_as_stated)
{
    for (int k = 1; k <= 6; k++) {
        const double fall = PLANT_IRON_FALL_D_MAX * k / 6.0;
        cfg.fall_d = fall;
        cfg.fall_q = PLANT_IRON_FALL_Q_MAX / PLANT_IRON_FALL_D_MAX * fall;
        cfg.shared = 0.0;
        start();
        const double i = cfg.current_a;
        TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, (1.0 - fall) * cfg.inductance_d_h,
                                  flux_at(i, 0.0).d / i);
        TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, (1.0 - cfg.fall_q) * cfg.inductance_q_h,
                                  flux_at(0.0, i).q / i);
        TEST_ASSERT_DOUBLE_WITHIN(ROUNDING, (1.0 - cfg.fall_q) * cfg.inductance_q_h,
                                  flux_at(0.0, -i).q / -i);
    }
}

/* i_d < 0 takes the magnet's saturation away: at most twice the inductance without flux. */
TEST(test_against_the_magnet_the_d_axis_has_more_inductance)
{
    cfg.fall_d = PLANT_IRON_FALL_D_MAX;
    cfg.shared = 0.0;
    start();
    TEST_ASSERT_TRUE(flux_at(-cfg.current_a, 0.0).d / -cfg.current_a > cfg.inductance_d_h);
    for (int k = -24; k <= 24; k++) {
        const double x = 0.125 * k;
        const plant_stiffness_t s = plant_iron_stiffness(&iron, (plant_dq_t){x * scale_d(), 0.0});
        TEST_ASSERT_TRUE(1.0 / s.straight.d <= 2.0 * cfg.inductance_d_h);
    }
}

/* Of the currents at a flux, along one axis: by central differences. */
static plant_dq_t slope(double flux_d, double flux_q, double way_d, double way_q)
{
    const plant_dq_t ahead = current_at(flux_d + way_d, flux_q + way_q);
    const plant_dq_t behind = current_at(flux_d - way_d, flux_q - way_q);
    const double way = 2.0 * (way_d + way_q);

    return (plant_dq_t){(ahead.d - behind.d) / way, (ahead.q - behind.q) / way};
}

/* di_d/dpsi_q = di_q/dpsi_d, so that of the fluxes too, and a closed way takes no energy. */
TEST(test_stiffness_is_the_slope_of_the_currents_and_reciprocal)
{
    const double tolerance = DIFFERENCE * 10.0 / cfg.inductance_d_h; /* it grows with the flux */

    for (int j = -4; j <= 4; j++) {
        for (int k = -4; k <= 4; k++) {
            const double d = 0.5 * j * scale_d();
            const double q = 0.5 * k * scale_q();
            const plant_stiffness_t s = plant_iron_stiffness(&iron, (plant_dq_t){d, q});
            const plant_dq_t by_d = slope(d, q, STEP * scale_d(), 0.0);
            const plant_dq_t by_q = slope(d, q, 0.0, STEP * scale_q());
            TEST_ASSERT_DOUBLE_WITHIN(tolerance, by_d.d, s.straight.d);
            TEST_ASSERT_DOUBLE_WITHIN(tolerance, by_q.q, s.straight.q);
            TEST_ASSERT_DOUBLE_WITHIN(tolerance, by_d.q, s.cross);
            TEST_ASSERT_DOUBLE_WITHIN(tolerance, by_q.d, s.cross);
        }
    }
}

/* A mirror through the d axis changes the sign of q, and nothing else. */
TEST(test_the_q_axis_has_no_sign)
{
    for (int k = -4; k <= 4; k++) {
        const double i_d = 0.5 * k * cfg.current_a;
        const plant_dq_t up = flux_at(i_d, 1.3 * cfg.current_a);
        const plant_dq_t down = flux_at(i_d, -1.3 * cfg.current_a);
        TEST_ASSERT_TRUE(up.d == down.d && up.q == -down.q);
    }
}

/* What saturates acts along the flux, the magnet's share included, whatever its direction. */
TEST(test_iron_that_both_axes_share_has_no_direction)
{
    cfg.inductance_q_h = cfg.inductance_d_h;
    cfg.fall_d = 0.2;
    /* g_q = g_d: f (1 - f_d)^2 (4 - f_d) = f_d (1 - f)^3. */
    double fall = 0.05;
    for (int k = 0; k < 100; k++) {
        fall = 0.2 / (0.64 * 3.8) * pow(1.0 - fall, 3.0);
    }
    cfg.fall_q = fall;
    cfg.shared = 1.0;
    start();
    const double g = 0.2 / (0.64 * 3.8);
    for (int k = 0; k < 21; k++) {
        const double angle = 0.3 * k;
        const double x = 1.7 * cos(angle) - 1.0;
        const double y = 1.7 * sin(angle);
        const plant_dq_t i = current_at(x * scale_d(), y * scale_q());
        /* Less the straight part that the unsaturated inductances leave. */
        const double d = i.d / cfg.current_a - ((1.0 - 3.0 * g) * x - g);
        const double q = i.q / cfg.current_a - (1.0 - g) * y;
        TEST_ASSERT_DOUBLE_WITHIN(1.0e-9, g * pow(1.7, 3.0), hypot(d, q));
        TEST_ASSERT_DOUBLE_WITHIN(1.0e-9, 0.0, d * sin(angle) - q * cos(angle));
    }
}

TEST(test_q_current_takes_flux_from_the_d_axis)
{
    cfg = (plant_iron_cfg_t){0.01, 0.01, 6.0, 0.2, 0.2, 1.0};
    start();
    /* At rated current 11 % of L_d I, as docs/configuration.md says. */
    TEST_ASSERT_DOUBLE_WITHIN(0.005 * scale_d(), -0.11 * scale_d(), flux_at(0.0, cfg.current_a).d);
    cfg.shared = 0.0;
    start();
    TEST_ASSERT_TRUE(fabs(flux_at(0.0, cfg.current_a).d) <= 0.0);
}

/* Of any motor in range, far beyond rated current: the map has an inverse, and it is found. */
TEST(test_each_current_has_one_flux)
{
    seeded_t seeded = {88675123U};

    for (int k = 0; k < 20000; k++) {
        start_any(&seeded);
        const plant_dq_t i = any_current(&seeded);
        const plant_dq_t flux = flux_at(i.d, i.q);
        const plant_dq_t again = current_at(flux.d, flux.q);
        const double tolerance = ROUNDING * (cfg.current_a + fabs(i.d) + fabs(i.q));
        TEST_ASSERT_DOUBLE_WITHIN(tolerance, i.d, again.d);
        TEST_ASSERT_DOUBLE_WITHIN(tolerance, i.q, again.q);
        const plant_stiffness_t s = plant_iron_stiffness(&iron, flux);
        TEST_ASSERT_TRUE(s.straight.d > 0.0);
        TEST_ASSERT_TRUE(s.straight.d * s.straight.q > s.cross * s.cross);
    }
}
