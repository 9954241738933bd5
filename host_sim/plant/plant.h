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
 * Bus: v(t) = bus_v * (1 + bus_ripple_fraction * sin(2 pi bus_ripple_hz * t)), taken at the start
 * of a period and held for it. The source is stiff both ways: current flowing back does not lift it.
 *
 * A plant is one plain struct without pointers: assigning it is a snapshot, and the copy goes on
 * exactly as the original does. Nothing depends on global state or on the machine's libm (only
 * floor, ceil and sqrt are used, which are exact), so equal configurations and inputs give equal
 * bytes. Compile without floating-point contraction for that to hold between machines.
 *
 * Not modelled: thermal drift, saturation of the iron, iron loss, switching transients other than
 * the dead time, bandwidth and delay of the sensors, voltage sag of the bus under load.
 */
#ifndef PLANT_PLANT_H
#define PLANT_PLANT_H

#include "inverter.h"
#include "motor.h"
#include "sensors.h"

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    double voltage_v;       /* V, > 0, mean */
    double ripple_fraction; /* peak ripple amplitude / voltage_v, 0 ... below 1 */
    double ripple_hz;       /* Hz, >= 0 */
    double device_drop_v;   /* V, >= 0, of each conducting switch or diode, independent of current;
                               below half the lowest bus voltage */
} plant_supply_cfg_t;

typedef struct {
    plant_motor_cfg_t motor;
    plant_inverter_cfg_t inverter;
    plant_supply_cfg_t supply;
    plant_sensor_cfg_t sensor;
} plant_cfg_t;

typedef struct {
    plant_motor_t motor;
    plant_inverter_t inverter;
    plant_sensors_t sensors;
    plant_supply_cfg_t supply;
    double bus_v;                      /* during the period that starts now */
    uint64_t periods;                  /* completed so far */
    uint32_t compare_next[PLANT_LEGS]; /* preload registers */
    uint32_t compare[PLANT_LEGS];      /* active in the period that starts now */
    bool gates_on;
} plant_t;

/* The truth at the present instant. */
typedef struct {
    double time_s;
    double theta_el_rad;     /* electrical, -pi ... pi */
    double theta_mech_rad;   /* mechanical, multi-turn */
    double omega_mech_rad_s; /* mechanical */
    double i_d_a;            /* true rotor frame */
    double i_q_a;
    double i_abc_a[PLANT_LEGS]; /* into the motor, sum zero */
    double torque_nm;           /* air gap, motoring positive */
    double bus_v;               /* of the period that starts now */
} plant_view_t;

/* Sets up a plant at time zero: no current, no load, gates off, all compare values zero. Returns
 * false and names the first field out of range in *bad_field ("motor.inertia_kg_m2"), else sets it
 * to NULL. On failure the plant must not be used. */
bool plant_init(plant_t *plant, const plant_cfg_t *cfg, const char **bad_field);

/* Preloads the compare values, 0 ... timer_counts (duty 0 ... 1), larger ones count as
 * timer_counts. In force after the next plant_step. */
void plant_write_compare(plant_t *plant, const uint32_t compare[PLANT_LEGS]);

/* Enables the switches, or opens all six. From the present instant. */
void plant_set_gates(plant_t *plant, bool on);

/* Load torque, N m, constant until changed. Positive opposes positive rotation; it is an external
 * torque and does not turn with the speed. From the present instant. */
void plant_set_load_torque(plant_t *plant, double torque_nm);

/* Converts the currents of phases a and b and the bus at the present instant. */
void plant_sample(plant_t *plant, plant_adc_t *adc);

/* Lets one PWM period pass, then takes over the preloaded compare values. */
void plant_step(plant_t *plant);

/* Reads the truth. Changes nothing. */
void plant_view(const plant_t *plant, plant_view_t *view);

#ifdef __cplusplus
}
#endif

#endif
