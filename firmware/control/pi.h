/*
 * PI controller with limited output and anti-windup, paper B (28)–(30) in backward-difference form:
 *     I(k) = I(k−1) + K_i·T·e(k),   u(k) = K_p·e(k) + I(k) + feed-forward, limited to ±limit
 *
 * Signals are Q15 per unit. The integral is Q30 (15 bits finer than the output), so that an error of
 * one LSB still integrates. Pure, no failure; call from the control interrupt.
 */
#ifndef PI_H
#define PI_H

#include <stdint.h>

/* Gain = mantissa / 2^shift. The configuration keeps the mantissa near full scale. */
typedef struct {
    int16_t kp;       /* proportional gain, ≥ 0 */
    uint8_t kp_shift; /* 0…30 */
    uint8_t ki_shift; /* 15…45, so K_i·T < 1 */
    int16_t ki;       /* integral gain × period, ≥ 0 */
} pi_cfg_t;

typedef struct {
    int32_t integral_q30;
} pi_t;

/* Set the integral so that the next output starts at `output` (Q15) with zero error. */
void pi_reset(pi_t *pi, int16_t output);

/*
 * One sample. error, feed_forward: Q15 in 32 bits, |error| ≤ 2^15, |feed_forward| ≤ 2^17.
 * limit: Q15, 0…32767. Returns u in ±limit, rounded down. Anti-windup: the integral stays within
 * ±limit and does not move further into a limit that the output has reached.
 */
int16_t pi_step(pi_t *pi, const pi_cfg_t *cfg, int32_t error, int32_t feed_forward, int32_t limit);

/*
 * Tell the controller that only u − excess of its last output could be used (Q15), as when the
 * voltage circle cuts one axis: the integral gives the excess back.
 */
void pi_unwind(pi_t *pi, int32_t excess);

#endif
