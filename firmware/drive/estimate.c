/* SPDX-License-Identifier: MIT */
#include "estimate.h"

#include "inlining.h"
#include "motor.h"
#include "trig.h"

#define COUNT_TO_ANGLE (65536U)
#define Q14_TO_Q16 (4)
#define Q16_TO_Q32_SHIFT (16U)
/* While the network is not trained, θ̂ moves by 1/64 of its distance to the vector in each tick. */
#define PULL_SHIFT (6U)
/* the filter of the residual has a time constant of 2^3 slow periods */
#define RESIDUAL_SHIFT (3U)
/* 1/8 turn is more than any acceleration of a motor makes the tracking loop lag */
#define LEFT_BEHIND (0x20000000U)
#define Q32_TO_Q16_SHIFT (16U)
#define CHANGE_MAX (0x20000000) /* of a speed in a tick: no limit */
/* Before its first edges a Hall sensor tells the middle of a sector of 60°, so it is off by 30°. */
#define HALF_SECTOR (0x15555555U)

void estimate_reset(rotor_t *rotor)
{
    rotor_position_reset(&rotor->position, 0U);
    rotor->residual = 0;
    rotor->failed = false;
}

void estimate_start(rotor_t *rotor, const nn_observer_cfg_t *cfg, step_t speed, dq_t current)
{
    nn_observer_start(&rotor->observer, cfg, speed, current,
                      trig_sincos(rotor_position_angle(&rotor->position)));
}

void estimate_place(rotor_t *rotor, rotor_position_t position)
{
    rotor->position = position;
}

/*
 * Returns the electrical turns of the shaft from the sensor's zero, Q32: count · pole_pairs · 2^16.
 * The product count · pole_pairs fits a word.
 */
static int64_t turns_of(uint16_t count, uint32_t pole_pairs)
{
    const uint32_t turns_q16 = (uint32_t)count * pole_pairs;

    return fx_signed64((uint64_t)turns_q16 << Q16_TO_Q32_SHIFT);
}

/* Whether the angle of this kind of sensor counts from anywhere, so that it has to be aligned. */
static bool has_free_zero(const drive_t *drive)
{
    const uint32_t kind = drive->cfg->sensor.kind;

    return (kind == (uint32_t)SENSOR_KIND_ENCODER) || (kind == (uint32_t)SENSOR_KIND_ENCODER_INDEX);
}

static bool is_hall(const sensor_cfg_t *cfg)
{
    return cfg->kind == (uint32_t)SENSOR_KIND_HALL;
}

/* Whether this difference of two angles is less than `limit`, below 2^31, either way. */
static bool lies_within(angle_t ahead, angle_t limit)
{
    return (ahead + limit) < (2U * limit);
}

/*
 * Whether the sensor has the rotor about where the observer has it. Beyond the limit its wires are
 * exchanged or its zero is wrong. The limit is below a quarter turn, from where on the torque would
 * turn round.
 */
static bool agrees(const rotor_t *rotor, const drive_t *drive)
{
    const angle_t ahead = rotor_position_angle(&rotor->angle_sensor.position) -
                          rotor_position_angle(&rotor->position);

    return lies_within(ahead, LEFT_BEHIND + (is_hall(&drive->cfg->sensor) ? HALF_SECTOR : 0U));
}

static angle_t measured_angle(const drive_t *drive, uint16_t count)
{
    return (angle_t)count * COUNT_TO_ANGLE * drive->cfg->sampling.sensor_pole_pairs;
}

/*
 * Returns by how much the speed may change in a tick. A Hall sensor that stands still and then
 * tells an edge corrects the angle by up to a sector at once. What made a rotor of fast_speed stop
 * within a sector would change its speed by fast_speed²/(2·sector) a tick, sector = 2^32/6. Other
 * sensors tell motion only.
 */
static step_t largest_change(const sensor_cfg_t *cfg)
{
    const uint32_t fast_q16 = fx_unsigned(cfg->hall.fast_speed) >> Q32_TO_Q16_SHIFT;
    const uint32_t stopping = 3U * (fast_q16 * fast_q16);

    return is_hall(cfg) ? fx_max(fx_signed(stopping), 1) : CHANGE_MAX;
}

/*
 * One tick of the tracking loop. In INIT, and where the angle was not known before, the loop is set
 * to the angle that it has to follow. So the turns are counted from the sensor's zero, whichever
 * electrical turn the rotor is in. An encoder that stops while the rotor turns leaves the loop
 * within milliseconds.
 */
static void follow_sensor(rotor_t *rotor, const drive_t *drive, uint16_t count)
{
    int32_t error;

    if ((drive->state == DRIVE_STATE_INIT) || !rotor->followed) {
        angle_sensor_start(&rotor->angle_sensor,
                           turns_of(count, drive->cfg->sampling.sensor_pole_pairs));
        rotor->aligned = !has_free_zero(drive);
    }
    error = angle_sensor_step(&rotor->angle_sensor, measured_angle(drive, count),
                              drive->motor.model.observer.speed_limit,
                              largest_change(&drive->cfg->sensor));
    rotor->followed = lies_within(fx_unsigned(error), LEFT_BEHIND) || !has_free_zero(drive);
}

/*
 * Chooses the source in RUN. A sensor that fails is not used again in this run: the next start
 * looks for the rotor anew.
 */
static estimate_source_t choose_in_run(rotor_t *rotor, const drive_t *drive)
{
    const sensor_cfg_t *const cfg = &drive->cfg->sensor;
    const step_t speed = fx_abs(rotor->observer.speed);
    const bool usable = rotor->followed && rotor->aligned && !rotor->failed;
    estimate_source_t source = (estimate_source_t)rotor->source;

    if ((source == ESTIMATE_SENSOR) && !usable) {
        rotor->failed = true;
        source = ESTIMATE_OBSERVER;
    } else if ((cfg->observer_above != 0) && (speed >= cfg->observer_above)) {
        source = ESTIMATE_OBSERVER;
    } else if (usable && ((cfg->observer_above == 0) || (speed <= cfg->sensor_below))) {
        rotor->failed = (source == ESTIMATE_OBSERVER) && !agrees(rotor, drive);
        source = rotor->failed ? ESTIMATE_OBSERVER : ESTIMATE_SENSOR;
    } else {
        /* between both speeds the source stays */
    }
    return source;
}

/* While a vector is imposed, it leads the estimate. */
static estimate_source_t choose(rotor_t *rotor, const drive_t *drive)
{
    estimate_source_t source = ESTIMATE_OBSERVER;

    if (drive->state == DRIVE_STATE_RUN) {
        source = choose_in_run(rotor, drive);
    } else if (!drive_is_driving(drive->state)) {
        source = (rotor->followed && rotor->aligned) ? ESTIMATE_SENSOR : ESTIMATE_OBSERVER;
    } else {
        /* a start without the sensor */
    }
    return source;
}

bool estimate_sense(rotor_t *rotor, const drive_t *drive, const drive_in_t *in)
{
    const uint8_t before = rotor->source;
    const bool runs = drive->state == DRIVE_STATE_RUN;

    if ((in->flags & DRIVE_FLAG_NO_ANGLE) == 0U) {
        follow_sensor(rotor, drive, in->angle);
    } else {
        rotor->followed = false;
    }
    rotor->source = (uint8_t)choose(rotor, drive);
    if (rotor->source != (uint8_t)ESTIMATE_OBSERVER) {
        if ((before != rotor->source) && runs) {
            angle_sensor_meet(&rotor->angle_sensor, rotor->position);
        }
        rotor->position = angle_sensor_position(&rotor->angle_sensor);
        nn_observer_follow(&rotor->observer, rotor->angle_sensor.speed);
    }
    return runs && rotor->failed && (before != (uint8_t)ESTIMATE_OBSERVER);
}

void estimate_align_sensor(rotor_t *rotor, const drive_t *drive)
{
    if (drive_has_sensor(drive) && rotor->followed && has_free_zero(drive)) {
        angle_sensor_align(&rotor->angle_sensor, drive->vector.position);
        rotor->aligned = true;
    }
}

bool estimate_may_take_sensor(const drive_t *drive)
{
    return drive_has_sensor(drive) && drive->rotor.followed && drive->rotor.aligned &&
           !drive->rotor.failed;
}

void estimate_take_sensor(rotor_t *rotor)
{
    rotor->source = (uint8_t)ESTIMATE_SENSOR;
    rotor->position = angle_sensor_position(&rotor->angle_sensor);
    nn_observer_follow(&rotor->observer, rotor->angle_sensor.speed);
}

void estimate_start_sensed(rotor_t *rotor, const nn_observer_cfg_t *cfg)
{
    const step_t speed = rotor->angle_sensor.speed;

    rotor->position = rotor->angle_sensor.position;
    /* This tick controls no current, so estimate_advance() does not run: advance θ̂ here. */
    rotor_position_step(&rotor->position, speed);
    estimate_start(rotor, cfg, speed, (dq_t){0, 0});
}

/* Returns θ̂ at the instant of the last prediction. Since then θ̂ has advanced by one tick. */
static sincos_t angle_before(const rotor_t *rotor)
{
    return trig_sincos(rotor_position_angle(&rotor->position) -
                       fx_unsigned(rotor->observer.speed_out));
}

void estimate_change(rotor_t *rotor, const nn_observer_cfg_t *cfg, int32_t flux_q27,
                     int32_t saliency_q13)
{
    nn_observer_change(&rotor->observer, cfg, flux_q27, saliency_q13, angle_before(rotor));
}

void estimate_accelerate(rotor_t *rotor, const drive_t *drive, step_t change)
{
    const int32_t share_q14 = drive_is_sensed(drive) ? 0 : drive->cfg->run.acceleration_q14;

    nn_observer_accelerate(&rotor->observer, &drive->motor.model.observer,
                           fx_mul_32x16(change, share_q14) * Q14_TO_Q16);
}

bool estimate_is_trained(const drive_t *drive)
{
    return (drive->state != DRIVE_STATE_ALIGN) &&
           (fx_abs(drive->vector.step) >= drive->cfg->startup.track_speed);
}

ab_t estimate_applied_voltage(ab_t ratio, int32_t bus_before, int32_t bus_now)
{
    const int32_t bus = fx_asr(bus_before + bus_now, 1U);

    return (ab_t){
        .alpha = fx_sat16(fx_asr(ratio.alpha * bus, 15U)),
        .beta = fx_sat16(fx_asr(ratio.beta * bus, 15U)),
    };
}

dq_t estimate_step(rotor_t *rotor, const drive_t *drive, sample_t sample)
{
    const angle_t theta = rotor_position_angle(&rotor->position);
    /*@ assert BLOCKS(theta); */
    nn_observer_t *const observer = &rotor->observer;
    const nn_observer_cfg_t *const cfg = &drive->motor.model.observer;
    const sincos_t angle = trig_sincos(theta);
    const ab_t current_ab = transforms_clarke(sample.phase_a, sample.phase_b);
    const ab_t voltage =
        estimate_applied_voltage(drive->control.ratio_acting, drive->bus, sample.bus);
    const dq_t current = transforms_park(current_ab, angle);

    nn_observer_predict(observer, cfg, current, voltage, angle);
    return current;
}

void estimate_train(rotor_t *rotor, const drive_t *drive)
{
    nn_observer_train(&rotor->observer, &drive->motor.model.observer);
}

void estimate_follow(rotor_t *rotor, const drive_t *drive)
{
    if (!drive_is_sensed(drive)) {
        nn_observer_follow(&rotor->observer, drive->vector.step);
    }
}

static step_t closing_step(const drive_t *drive)
{
    const angle_t distance = rotor_position_angle(&drive->vector.position) -
                             rotor_position_angle(&drive->rotor.position);

    return fx_asr(fx_signed(distance), PULL_SHIFT);
}

void estimate_advance(rotor_t *rotor, const drive_t *drive, bool pulled)
{
    step_t step = rotor->observer.speed_out;

    if (pulled && !drive_is_sensed(drive)) {
        step += closing_step(drive);
    }
    rotor_position_step(&rotor->position, step);
}

step_t estimate_calm_speed(const drive_t *drive)
{
    const step_t fast = 2 * drive->cfg->startup.handover_speed;
    const step_t own = drive->rotor.observer.speed;

    return (fx_abs(own) >= fast) ? own : drive->motion.speed_loop.reference;
}

/*
 * Returns the current that the model does not explain. At rest the leg that carries no current acts
 * on the q axis. Its dead time takes up the voltage that the control applies there, but the model
 * computes a current from this voltage. Along d all legs conduct, so the error along d is used at
 * rest.
 */
static int32_t unexplained_current(const drive_t *drive)
{
    const dq_t error = drive->rotor.observer.rotated_error;

    return fx_abs(drive_is_held(drive) ? error.d : error.q);
}

/*
 * Fails a sensor whose rotor is more than a quarter turn off its angle, so that the torque acts the
 * other way. The current control knows of the EMF by the speed of the sensor. An EMF of the other
 * sign makes the integral along q go against it by more than all of it; along d it does not show on
 * which side the rotor is. voltage_max covers what the model does not know of resistance and dead
 * time. Hall sensors tell of a rotor that turns back at the next edge only, so a slow one is not
 * judged; nor is any sensor beside a voltage drive, which hands over with integrals that are off
 * for some periods.
 */
RARE static void doubt_sensor(rotor_t *rotor, const drive_t *drive)
{
    const sensor_cfg_t *const cfg = &drive->cfg->sensor;
    const step_t speed = rotor->observer.speed;
    const bool told = !is_hall(cfg) || (fx_abs(speed) >= fx_asr(cfg->hall.fast_speed, 1U));
    const int32_t unknown = drive->cfg->supervision.voltage_max;
    const int32_t emf = motor_emf(&drive->motor, drive_speed_q15(drive, fx_abs(speed)));
    const int32_t more = pi_output(&drive->control.current_loop.pi_q);
    const int32_t against = (speed < 0) ? more : -more;

    if (told && (emf >= unknown) && (against > (emf + unknown))) {
        rotor->failed = true;
    }
}

void estimate_refine(rotor_t *rotor, const drive_t *drive, step_t calm)
{
    rotor->residual = fx_approach(rotor->residual, unexplained_current(drive), RESIDUAL_SHIFT);
    nn_observer_refresh(&rotor->observer, &drive->motor.model.observer, calm);
    if ((drive->state == DRIVE_STATE_RUN) && drive_is_sensed(drive) &&
        (drive->cfg->voltage_drive.enabled == 0U)) {
        doubt_sensor(rotor, drive);
    }
}
