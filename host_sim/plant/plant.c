/* SPDX-License-Identifier: MIT */
#include "plant.h"

#include "bridge.h"
#include "check.h"
#include "knee.h"

#include <string.h>

/* Halvings of a segment in which the comparators trip. */
#define TRIP_HALVINGS 20

/*
 * The low pass of the sensors takes the current for a straight line between two instants. With the
 * motor's rate times the time between them at most this the current leaves the line by less than
 * its square / 8 = 3e-4 of its scale.
 */
#define FOLLOWED_STEP 0.05

static const char *supply_bad_field(const plant_supply_cfg_t *cfg)
{
    const double lowest_v = cfg->voltage_v * (1.0 - cfg->ripple_fraction);
    const plant_check_t checks[] = {
        {"supply.voltage_v", plant_is_positive(cfg->voltage_v)},
        {"supply.ripple_fraction", cfg->ripple_fraction >= 0.0 && cfg->ripple_fraction < 1.0},
        {"supply.ripple_hz", plant_is_not_negative(cfg->ripple_hz)},
        {"supply.device_drop_v",
         plant_is_not_negative(cfg->device_drop_v) && 2.0 * cfg->device_drop_v < lowest_v},
        {"supply.commutation_knee_a", plant_is_not_negative(cfg->commutation_knee_a)},
        {"supply.capacitance_f", plant_is_not_negative(cfg->capacitance_f)},
        {"supply.resistance_ohm", plant_is_not_negative(cfg->resistance_ohm)},
    };
    return plant_first_bad(checks, sizeof checks / sizeof checks[0]);
}

static double present_time_s(const plant_t *plant)
{
    return (double)plant->periods * plant->inverter.period_s;
}

static double supply_v(const plant_t *plant, double time_s)
{
    const plant_supply_cfg_t *supply = &plant->supply;
    if (!(supply->ripple_fraction > 0.0)) {
        return supply->voltage_v;
    }
    const double cycles = supply->ripple_hz * time_s;
    const double phase_rad = PLANT_TWO_PI * (cycles - floor(cycles));
    const double ripple = supply->ripple_fraction * plant_rotation_from_angle(phase_rad).sine;
    return supply->voltage_v * (1.0 + ripple);
}

static double supply_now_v(const plant_t *plant)
{
    return supply_v(plant, present_time_s(plant));
}

static bool has_capacitor(const plant_t *plant)
{
    return plant->supply.capacitance_f > 0.0;
}

/* The supply's voltage on the bus: at once, or as far as it charges the capacitor in a time. */
static double fed_bus_v(const plant_t *plant, double duration_s)
{
    const double supply_v = supply_now_v(plant);
    const double series_s = plant->supply.resistance_ohm * plant->supply.capacitance_f;
    if (!has_capacitor(plant)) {
        return supply_v;
    }
    if (!(plant->bus_v < supply_v)) {
        return plant->bus_v;
    }
    if (!(series_s > 0.0)) {
        return supply_v;
    }
    const double part = duration_s / series_s;
    return (plant->bus_v + part * supply_v) / (1.0 + part);
}

/* Dead times of a period: two of each leg. */
#define DEAD_TIMES (2.0 * PLANT_LEGS)

/*
 * A knee so much smaller than what a dead time changes the current by is an ideal diode's, and
 * takes so many steps.
 */
#define KNEE_STEPS_MAX 1000.0

double plant_least_knee(const plant_cfg_t *cfg)
{
    const double period_s = 1.0 / cfg->inverter.pwm_frequency_hz;
    const double bus_v = cfg->supply.voltage_v * (1.0 + cfg->supply.ripple_fraction);
    const double drop_v = cfg->supply.device_drop_v;
    const double open_vs = (0.5 * bus_v + drop_v) * DEAD_TIMES * cfg->inverter.dead_time_s;
    const double inductance_h = fmin(cfg->motor.inductance_d_h, cfg->motor.inductance_q_h);
    /* Steps of the slope half / (2 knee): see plant_knee_run. */
    return 0.5 * (open_vs + drop_v * period_s) / inductance_h /
           (KNEE_STEPS_MAX * PLANT_MOTOR_FED_STEP);
}

static void choose_legs(plant_t *plant)
{
    plant->ideal_legs =
        !(plant->supply.device_drop_v > 0.0) && !has_capacitor(plant) && plant->broken == 0U;
}

/* Whether each phase hangs at one leg. */
static bool connect_wires(plant_t *plant, const unsigned wire[PLANT_LEGS])
{
    uint32_t found = 0;
    for (unsigned leg = 0; leg < PLANT_LEGS; leg++) {
        plant->phase[leg] = (leg + wire[leg]) % PLANT_LEGS;
        found |= 1U << plant->phase[leg];
    }
    return found == PLANT_ALL_LEGS;
}

/* Of a mask of legs. */
static uint32_t phases_of(const plant_t *plant, uint32_t legs)
{
    uint32_t phases = 0;
    for (unsigned leg = 0; leg < PLANT_LEGS; leg++) {
        phases |= (legs >> leg & 1U) << plant->phase[leg];
    }
    return phases;
}

bool plant_init(plant_t *plant, const plant_cfg_t *cfg, const char **bad_field)
{
    memset(plant, 0, sizeof *plant);
    if (!plant_motor_init(&plant->motor, &cfg->motor, bad_field) ||
        !plant_inverter_init(&plant->inverter, &cfg->inverter, bad_field) ||
        !plant_sensors_init(&plant->sensors, &cfg->sensor, bad_field) ||
        !plant_shaft_init(&plant->shaft, &cfg->shaft, bad_field)) {
        return false;
    }
    *bad_field = supply_bad_field(&cfg->supply);
    if (*bad_field != NULL) {
        return false;
    }
    if (cfg->supply.commutation_knee_a > 0.0 &&
        cfg->supply.commutation_knee_a < plant_least_knee(cfg)) {
        *bad_field = "supply.commutation_knee_a";
        return false;
    }
    if (!plant_is_not_negative(cfg->trip_a)) {
        *bad_field = "trip_a";
        return false;
    }
    if (!plant_is_not_negative(cfg->fan_nm_s2)) {
        *bad_field = "fan_nm_s2";
        return false;
    }
    if (!connect_wires(plant, cfg->wire)) {
        *bad_field = "wire";
        return false;
    }
    plant->trip_a = cfg->trip_a;
    plant->fan_nm_s2 = cfg->fan_nm_s2;
    plant->supply = cfg->supply;
    plant->bus_v = supply_now_v(plant);
    plant_set_temperature(plant, PLANT_AMBIENT_C);
    choose_legs(plant);
    return true;
}

void plant_write_compare(plant_t *plant, const uint32_t compare[PLANT_LEGS])
{
    for (int leg = 0; leg < PLANT_LEGS; leg++) {
        plant->compare_next[plant->phase[leg]] = compare[leg];
    }
}

void plant_set_gates(plant_t *plant, bool on)
{
    plant->gates_on = on;
}

bool plant_take_trip(plant_t *plant)
{
    const bool tripped = plant->tripped;
    plant->tripped = false;
    return tripped;
}

/*
 * A fan alone slows the load as w' = -c/J w^2: over a period its torque is c w^2 / (1 + c w T/J) in
 * the mean.
 */
static double fan_nm(const plant_t *plant)
{
    const double w = plant_motor_load_speed(&plant->motor);
    const double slowing = plant->fan_nm_s2 * fabs(w);
    return slowing * w /
           (1.0 + slowing * plant->inverter.period_s * plant_motor_load_gain(&plant->motor));
}

void plant_set_load_torque(plant_t *plant, double torque_nm)
{
    plant->load_nm = torque_nm;
    plant->motor.load_torque_nm = torque_nm + fan_nm(plant);
}

void plant_set_supply(plant_t *plant, double voltage_v)
{
    plant->supply.voltage_v = voltage_v;
    plant->bus_v = fed_bus_v(plant, 0.0);
}

void plant_break_phases(plant_t *plant, uint32_t broken)
{
    plant->broken = broken & PLANT_ALL_LEGS;
    plant_bridge_break(&plant->motor, phases_of(plant, plant->broken));
    choose_legs(plant);
}

void plant_block_rotor(plant_t *plant, bool blocked)
{
    plant_motor_block(&plant->motor, blocked);
}

void plant_turn_rotor(plant_t *plant, double angle_el_rad)
{
    plant_motor_turn(&plant->motor, angle_el_rad);
}

void plant_set_temperature(plant_t *plant, double temperature_c)
{
    plant_sensors_set_temperature(&plant->sensors, temperature_c);
}

void plant_sample(plant_t *plant, plant_adc_t *adc)
{
    double current[PLANT_LEGS];
    plant_phases(plant_motor_current(&plant->motor), current);
    plant_sensors_convert(&plant->sensors, current[plant->phase[0]], current[plant->phase[1]],
                          plant->bus_v, adc);
    adc->angle = plant_sensors_angle(&plant->sensors, plant_motor_angle_mech(&plant->motor));
}

plant_shaft_reading_t plant_read_shaft(plant_t *plant)
{
    return plant_shaft_read(&plant->shaft, plant_motor_angle_mech(&plant->motor));
}

void plant_scale_sensors(plant_t *plant, const double current[PLANT_LEGS], double bus)
{
    plant_sensors_scale(&plant->sensors, current, bus);
}

void plant_set_clock(plant_t *plant, double ratio)
{
    plant_inverter_set_clock(&plant->inverter, ratio);
}

/* Ideal legs need no look at the currents: their potentials are the rails. */
static bool is_ideal(const plant_t *plant, const plant_segment_t *segment)
{
    return plant->ideal_legs && (segment->high | segment->low) == PLANT_ALL_LEGS;
}

/* Voltage vector of each mask of high legs, in units of the bus. */
#define TWO_THIRDS (2.0 / 3.0)
#define ONE_THIRD (1.0 / 3.0)
#define ROOT_THIRD (1.0 / PLANT_SQRT3)

static const plant_vector_t unit_vector[PLANT_ALL_LEGS + 1U] = {
    {0.0, 0.0},
    {TWO_THIRDS, 0.0},
    {-ONE_THIRD, ROOT_THIRD},
    {ONE_THIRD, ROOT_THIRD},
    {-ONE_THIRD, -ROOT_THIRD},
    {ONE_THIRD, -ROOT_THIRD},
    {-TWO_THIRDS, 0.0},
    {0.0, 0.0},
};

/*
 * What acts in a whole period. A supply without capacitor moves on in it: its voltage in the
 * middle.
 */
static double acting_bus_v(const plant_t *plant)
{
    const double half_s = 0.5 * plant->inverter.period_s;
    return has_capacitor(plant) ? plant->bus_v : supply_v(plant, present_time_s(plant) + half_s);
}

/* What has gathered of a run, which may be nothing. */
static void end_run(plant_t *plant, unsigned pending, const plant_interval_t run[])
{
    if (pending > 0U) {
        plant_motor_run_driven(&plant->motor, pending, run);
    }
}

/* With two wires open no current is left to commutate. */
static bool is_soft(const plant_rails_t *rails)
{
    return rails->knee_a > 0.0 && (rails->broken & (rails->broken - 1U)) == 0U;
}

static void run_bridge(plant_t *plant, const plant_rails_t *rails, const plant_segment_t *segment,
                       double *meter)
{
    if (is_soft(rails)) {
        plant_knee_run(&plant->motor, segment, rails, meter);
    } else {
        plant_bridge_run(&plant->motor, segment, rails, meter);
    }
}

/*
 * Ideal segments go to the motor in runs as long as possible. Adds the charge that the bridge has
 * taken from the capacitor, if there is one, to *charge_c.
 */
static void run_unseen(plant_t *plant, const plant_rails_t *rails, unsigned count,
                       const plant_segment_t segments[], double *charge_c)
{
    double *const meter = has_capacitor(plant) ? charge_c : NULL;
    plant_interval_t run[PLANT_SEGMENTS_MAX];
    unsigned pending = 0;
    for (unsigned k = 0; k < count; k++) {
        const plant_segment_t *segment = &segments[k];
        if (is_ideal(plant, segment)) {
            const plant_vector_t unit = unit_vector[segment->high];
            run[pending].duration_s = segment->duration_s;
            run[pending].v.alpha = rails->bus_v * unit.alpha;
            run[pending].v.beta = rails->bus_v * unit.beta;
            pending++;
        } else {
            end_run(plant, pending, run);
            pending = 0;
            run_bridge(plant, rails, segment, meter);
        }
    }
    end_run(plant, pending, run);
}

/* The sensors are those of the first two legs. */
static void follow(plant_t *plant, double duration_s, const double from[], const double to[])
{
    const unsigned *const phase = plant->phase;
    const double from_a[2] = {from[phase[0]], from[phase[1]]};
    const double to_a[2] = {to[phase[0]], to[phase[1]]};
    plant_sensors_follow(&plant->sensors, duration_s, from_a, to_a);
}

/* One segment in parts, so short that the sensors can follow from one end to the other. */
static void run_followed(plant_t *plant, const plant_rails_t *rails, const plant_segment_t *segment,
                         double *charge_c)
{
    const double parts =
        plant_motor_steps(segment->duration_s * plant_motor_rate(&plant->motor) / FOLLOWED_STEP);
    plant_segment_t part = *segment;
    double from[PLANT_LEGS];
    double to[PLANT_LEGS];
    part.duration_s = segment->duration_s / parts;
    plant_phases(plant_motor_current(&plant->motor), to);
    for (int64_t left = (int64_t)parts; left > 0; left--) {
        memcpy(from, to, sizeof from);
        run_unseen(plant, rails, 1, &part, charge_c);
        plant_phases(plant_motor_current(&plant->motor), to);
        follow(plant, part.duration_s, from, to);
    }
}

static void run_segments(plant_t *plant, const plant_rails_t *rails, unsigned count,
                         const plant_segment_t segments[], double *charge_c)
{
    if (!plant_sensors_lag(&plant->sensors)) {
        run_unseen(plant, rails, count, segments, charge_c);
        return;
    }
    for (unsigned k = 0; k < count; k++) {
        run_followed(plant, rails, &segments[k], charge_c);
    }
}

/* What a segment changes. */
typedef struct {
    plant_motor_state_t motor;
    double seen_a[2];
} instant_t;

static instant_t keep(const plant_t *plant)
{
    const double *const seen_a = plant->sensors.seen_a;
    return (instant_t){plant->motor.now, {seen_a[0], seen_a[1]}};
}

static void go_back(plant_t *plant, const instant_t *to)
{
    plant->motor.now = to->motor;
    memcpy(plant->sensors.seen_a, to->seen_a, sizeof to->seen_a);
}

static bool is_beyond_trip(const plant_t *plant)
{
    double current[PLANT_LEGS];
    plant_phases(plant_motor_current(&plant->motor), current);
    return fabs(current[0]) > plant->trip_a || fabs(current[1]) > plant->trip_a ||
           fabs(current[2]) > plant->trip_a;
}

/*
 * The comparators trip within a segment that begins like this: the plant goes to the instant at
 * which they do. Returns the time from the beginning.
 */
static double run_to_trip(plant_t *plant, const plant_rails_t *rails, const instant_t *from,
                          const plant_segment_t *segment, double *charge_c)
{
    plant_segment_t part = *segment;
    double early_s = 0.0;
    double late_s = segment->duration_s;
    for (int k = 0; k < TRIP_HALVINGS; k++) {
        double unused_c = 0.0;
        part.duration_s = 0.5 * (early_s + late_s);
        go_back(plant, from);
        run_segments(plant, rails, 1, &part, &unused_c);
        if (is_beyond_trip(plant)) {
            late_s = part.duration_s;
        } else {
            early_s = part.duration_s;
        }
    }
    part.duration_s = late_s;
    go_back(plant, from);
    run_segments(plant, rails, 1, &part, charge_c);
    return late_s;
}

/*
 * Up to the instant at which the comparators trip; the rest of the period with all switches open.
 */
static void run_watched(plant_t *plant, const plant_rails_t *rails, const plant_pattern_t *pattern,
                        double *charge_c)
{
    plant_segment_t open = {plant->inverter.period_s, 0, 0};
    for (unsigned k = 0; k < pattern->count && plant->gates_on; k++) {
        const plant_segment_t *segment = &pattern->segment[k];
        const instant_t before = keep(plant);
        double segment_c = 0.0;
        run_segments(plant, rails, 1, segment, &segment_c);
        if (is_beyond_trip(plant)) {
            segment_c = 0.0;
            open.duration_s -= run_to_trip(plant, rails, &before, segment, &segment_c);
            plant->tripped = true;
            plant->gates_on = false;
        } else {
            open.duration_s -= segment->duration_s;
        }
        *charge_c += segment_c;
    }
    if (!plant->gates_on && open.duration_s > 0.0) {
        plant_rails_t diodes = *rails;
        diodes.knee_a = 0.0;
        plant_inverter_forget(&plant->inverter);
        run_segments(plant, &diodes, 1, &open, charge_c);
    }
}

/* One period. Returns the charge that the bridge has taken from the capacitor, if there is one. */
static double run_pattern(plant_t *plant, const plant_pattern_t *pattern)
{
    const plant_rails_t rails = {acting_bus_v(plant), plant->supply.device_drop_v,
                                 plant->gates_on ? plant->supply.commutation_knee_a : 0.0,
                                 phases_of(plant, plant->broken)};
    double charge_c = 0.0;
    if (plant->gates_on && plant->trip_a > 0.0) {
        run_watched(plant, &rails, pattern, &charge_c);
    } else {
        run_segments(plant, &rails, pattern->count, pattern->segment, &charge_c);
    }
    return charge_c;
}

/* The capacitor gives what the bridge has taken, then takes what the supply gives. */
static void settle_bus(plant_t *plant, double charge_c)
{
    if (has_capacitor(plant)) {
        const double v = plant->bus_v;
        const double square = v * v - 2.0 * v * charge_c / plant->supply.capacitance_f;
        plant->bus_v = (square > 0.0) ? sqrt(square) : 0.0;
    }
    plant->bus_v = fed_bus_v(plant, plant->inverter.period_s);
}

void plant_step(plant_t *plant)
{
    plant_pattern_t pattern;
    plant->motor.load_torque_nm = plant->load_nm + fan_nm(plant);
    if (plant->gates_on) {
        plant_inverter_pattern(&plant->inverter, plant->compare, &pattern);
    } else {
        plant_inverter_off(&plant->inverter, &pattern);
    }
    const double charge_c = run_pattern(plant, &pattern);
    plant_motor_wrap(&plant->motor);
    plant_sensors_drift(&plant->sensors, plant->inverter.period_s);
    plant->periods++;
    settle_bus(plant, charge_c);
    for (int leg = 0; leg < PLANT_LEGS; leg++) {
        plant->compare[leg] = plant->compare_next[leg];
    }
}

/*
 * From the axis of the phase at leg a on, where the wires turn in the order of their names. Two
 * that are exchanged make the bridge's field turn the other way, which no shift of the angle tells.
 */
static double terminal_angle(const plant_t *plant)
{
    const double theta = plant->motor.now.theta_el_rad;
    const bool in_order = plant->phase[1] == (plant->phase[0] + 1U) % PLANT_LEGS;
    const double shift = in_order ? plant->phase[0] * PLANT_TWO_PI / PLANT_LEGS : 0.0;
    return (shift > 0.0) ? remainder(theta - shift, PLANT_TWO_PI) : theta;
}

void plant_view(const plant_t *plant, plant_view_t *view)
{
    view->time_s = present_time_s(plant);
    view->theta_el_rad = terminal_angle(plant);
    view->theta_mech_rad = plant_motor_angle_mech(&plant->motor);
    view->omega_mech_rad_s = plant->motor.now.omega_el_rad_s / plant->motor.pole_pairs;
    view->i_d_a = plant_motor_i_d(&plant->motor);
    view->i_q_a = plant_motor_i_q(&plant->motor);
    double current[PLANT_LEGS];
    plant_phases(plant_motor_current(&plant->motor), current);
    for (int leg = 0; leg < PLANT_LEGS; leg++) {
        view->i_abc_a[leg] = current[plant->phase[leg]];
    }
    view->torque_nm = plant_motor_torque(&plant->motor);
    view->bus_v = plant->bus_v;
}
