/* SPDX-License-Identifier: MIT */
/*
 * The simulated drive hardware: PWM inverter, motor with load, current and bus sensing.
 *
 * Time advances in PWM periods. One control tick on the host is
 *
 *     plant_sample -> control step -> plant_write_compare, plant_set_gates -> plant_step
 *
 * The present instant is always the start of a period, the middle of the low sides' on-time. A
 * compare value written at tick k is preloaded and acts from tick k+1 to tick k+2, as in a timer
 * with its preload register on. The gate enable and the load act at once, from the present instant.
 *
 * Supply: s(t) = voltage_v * (1 + ripple_fraction * sin(2 pi ripple_hz * t)). The bus voltage is
 * held for a period. Without a capacitor it is the supply's at the start of the period: stiff both
 * ways, current flowing back does not lift it. With one, at the end of each period of length T
 *   C/2 v^2 -= v * (charge that has left the positive rail)   the energy that the bridge has taken
 *   v = (v + a s) / (1 + a) if v < s, a = T / (R_s C);  v = s for R_s = 0
 * so the rectifier charges like a diode, in backward Euler steps, and energy fed back stays in the
 * capacitor exactly.
 *
 * Comparators: at the instant at which a phase current exceeds trip_a in either direction all six
 * switches open, as by a timer's break input, and stay so until somebody enables them again; the
 * plant remembers that it tripped until it is asked. The instant is that of the first segment
 * between two switchings at whose end the current is beyond, bisected to 2^-20 of the segment; a
 * peak within one segment goes unseen. They have no low pass.
 *
 * A plant is one plain struct without pointers: assigning it is a snapshot, and the copy goes on
 * exactly as the original does. Nothing depends on global state or on the machine's libm (only
 * floor, ceil and sqrt are used, which are exact), so equal configurations and inputs give equal
 * bytes. Compile without floating-point contraction for that to hold between machines.
 *
 * Not modelled: thermal drift, iron loss, switching transients other than the dead time, ripple of
 * the bus within a period.
 */
#ifndef PLANT_PLANT_H
#define PLANT_PLANT_H

#include "inverter.h"
#include "motor.h"
#include "sensors.h"
#include "shaft_sensor.h"

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    double voltage_v;       /* V, > 0, mean */
    double ripple_fraction; /* peak ripple amplitude / voltage_v, 0 ... below 1 */
    double ripple_hz;       /* Hz, >= 0 */
    /*
     * V, >= 0, of each conducting switch or diode, independent of current; below half the lowest
     * supply voltage
     */
    double device_drop_v;
    /* A, >= 0, of legs that commutate softly while they switch, knee.h; 0: ideal diodes */
    double commutation_knee_a;
    double capacitance_f;  /* F, >= 0, of the bus; 0: stiff */
    double resistance_ohm; /* Ohm, >= 0, between supply and capacitor; without one it is not used */
} plant_supply_cfg_t;

typedef struct {
    plant_motor_cfg_t motor;
    plant_inverter_cfg_t inverter;
    plant_supply_cfg_t supply;
    plant_sensor_cfg_t sensor;
    plant_shaft_cfg_t shaft;
    double trip_a; /* A, >= 0, of the comparators; 0: there are none */
    double
        fan_nm_s2; /* N m s2, >= 0: load torque over the square of the load's speed, against it */
    /*
     * at leg k hangs phase (k + wire[k]) modulo 3 of the motor, each at one leg; zeros: as they are
     * named
     */
    unsigned wire[PLANT_LEGS];
} plant_cfg_t;

typedef struct {
    plant_motor_t motor;
    plant_inverter_t inverter;
    plant_sensors_t sensors;
    plant_shaft_t shaft;
    plant_supply_cfg_t supply;
    double bus_v;                      /* at the start of the period */
    uint64_t periods;                  /* completed so far */
    uint32_t compare_next[PLANT_LEGS]; /* preload registers */
    uint32_t compare[PLANT_LEGS];      /* active in the period that starts now */
    uint32_t broken;                   /* mask of the legs whose wire is open */
    bool
        ideal_legs; /* a leg's potential is that of its rail, and nobody asks for the bus current */
    bool gates_on;
    double trip_a;
    bool tripped;
    double load_nm;             /* as set */
    double fan_nm_s2;           /* and what grows with the speed comes on top */
    unsigned phase[PLANT_LEGS]; /* at each leg; all that the bridge does is by phases */
} plant_t;

/* Temperature of the power stage until it is set, degrees C. */
#define PLANT_AMBIENT_C 25.0

/* The truth at the present instant. */
typedef struct {
    double time_s;
    /*
     * electrical, -pi ... pi, from the axis of the phase at leg a on; with two exchanged wires from
     * that of phase a on
     */
    double theta_el_rad;
    double theta_mech_rad;   /* mechanical, multi-turn */
    double omega_mech_rad_s; /* mechanical */
    double i_d_a;            /* true rotor frame */
    double i_q_a;
    double i_abc_a[PLANT_LEGS]; /* of the legs into the motor, sum zero */
    double torque_nm;           /* air gap, motoring positive */
    double bus_v;               /* at the start of the period */
} plant_view_t;

/*
 * Sets up a plant at time zero: no current, no load, gates off, all compare values zero. Returns
 * false and names the first field out of range in *bad_field ("motor.inertia_kg_m2"), else sets it
 * to NULL. On failure the plant must not be used.
 */
bool plant_init(plant_t *plant, const plant_cfg_t *cfg, const char **bad_field);

/*
 * Smallest supply.commutation_knee_a other than 0 of a plant whose other fields are in range, A. It
 * takes a dead time, or a drop, to be of any use.
 */
double plant_least_knee(const plant_cfg_t *cfg);

/*
 * Preloads the compare values, 0 ... timer_counts (duty 0 ... 1), larger ones count as
 * timer_counts. In force after the next plant_step.
 */
void plant_write_compare(plant_t *plant, const uint32_t compare[PLANT_LEGS]);

/*
 * Enables the switches, or opens all six. From the present instant, unless the comparators see to
 * it.
 */
void plant_set_gates(plant_t *plant, bool on);

/* Whether the comparators have opened the switches since the last call. */
bool plant_take_trip(plant_t *plant);

/*
 * Load torque, N m, constant until changed. Positive opposes positive rotation; it is an external
 * torque and does not turn with the speed. That of fan_nm_s2 comes on top. From the present
 * instant.
 */
void plant_set_load_torque(plant_t *plant, double torque_nm);

/* Mean supply voltage, V, > 0. From the present instant; a charged capacitor keeps what it has. */
void plant_set_supply(plant_t *plant, double voltage_v);

/*
 * Opens the wires at the legs in a mask (bit k is leg k), closes the others. From the present
 * instant; the current of a wire that opens is gone at once, with its energy.
 */
void plant_break_phases(plant_t *plant, uint32_t broken);

/* Stops the shaft dead and holds it, or lets it go. From the present instant. */
void plant_block_rotor(plant_t *plant, bool blocked);

/* Turns the rotor by an electrical angle, rad, |x| < 1e6; currents and speed stay as they are. */
void plant_turn_rotor(plant_t *plant, double angle_el_rad);

/* Temperature of the power stage, degrees C. */
void plant_set_temperature(plant_t *plant, double temperature_c);

/* Converts the currents of legs a and b, bus and temperature at the present instant. */
void plant_sample(plant_t *plant, plant_adc_t *adc);

/* What the sensor of the shaft reads at the present instant. Once a period. */
plant_shaft_reading_t plant_read_shaft(plant_t *plant);

/* Sensors that have failed: see plant_sensors_scale(). */
void plant_scale_sensors(plant_t *plant, const double current[PLANT_LEGS], double bus);

/*
 * The clock of the timer runs so many times as fast as it should from the next period on; 1 is
 * healthy.
 */
void plant_set_clock(plant_t *plant, double ratio);

/* Lets one PWM period pass, then takes over the preloaded compare values. */
void plant_step(plant_t *plant);

/* Reads the truth. Changes nothing. */
void plant_view(const plant_t *plant, plant_view_t *view);

#ifdef __cplusplus
}
#endif

#endif
