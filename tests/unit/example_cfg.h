/* SPDX-License-Identifier: MIT */
/*
 * A valid configuration, written out: motor A (paper A, table 1) on a 310 V inverter with 12-bit
 * converters of ±20 A and 450 V, 10 kHz.
 *
 *   T = 100 µs, slow period 1 ms; I_b = 40 A (twice full scale), U_b = 450 V
 *   R = 2.125 Ω, L = 11.6 mH, φ = 0.387 Wb, 2 pole pairs, J = 0.003 kg·m², up to 2000 rpm
 *   2000 rpm = 418.879 rad/s el. = 28633115 steps
 *   speed_shift 11: Ω_b = 2^26/2^32·2π/T = 981.748 rad/s
 *   φ/L = 33.362 A < I_b, so s = 1 and I_x = 80 A
 */
#ifndef EXAMPLE_CFG_H
#define EXAMPLE_CFG_H

#include "config_guard.h"
#include "drive_cfg.h"

static inline sampling_cfg_t example_sampling_cfg(void)
{
    return (sampling_cfg_t){
        .current_shift = 3U, /* 15 − 12 bits */
        .bus_shift = 3U,
        .offset_log2 = 8U,
    };
}

static inline protection_cfg_t example_protection_cfg(void)
{
    return (protection_cfg_t){
        .current_max = 14746, /* 18 A / 40 A */
        .bus_max = 29127,     /* 400 V / 450 V */
        .bus_min = 14564,     /* 200 V / 450 V */
        .offset_max = 819,    /* 1 A / 40 A */
    };
}

/* κ = 0.005, κ_p = 0.1, no momentum. */
static inline nn_observer_cfg_t example_observer_cfg(void)
{
    return (nn_observer_cfg_t){
        .decay = 4802,      /* T·R/L·I_b/I_x = 0.0183190/2, times 2^19 */
        .volt_gain = 25423, /* T/L·U_b/I_x = 0.0484914, times 2^19 */
        .weight_shift = 7U,
        .flux_q27 = 55972264, /* 33.362 A / 80 A, times 2^27 */
        .iq_gain_q14 = 16384, /* L_d/L_q = 1 */
        .saliency_q13 = 8192, /* L_q/L_d = 1 */
        .current_shift = 1U,
        /* κ·I_b·I_x/(φ/L)²·4/2π = 0.00915154 steps per unit of b, times 2^12 */
        .gradient_shift = 12U,
        .eta = 19192,
        .eta_shift = 9U,
        .kappa_p = 23990, /* 0.183031, times 2^12, times 2^5 */
        .kappa_p_shift = 5U,
        .momentum_q15 = 0,
        .speed_limit = 35791394,  /* 2500 rpm */
        .corner = 12522209,       /* R/L = 183.19 rad/s */
        .rho_max_q13 = 0,         /* off */
        .rho_speed_min = 1288490, /* 90 rpm */
    };
}

/* 500 Hz, integral corner 50 Hz. */
static inline current_loop_cfg_t example_current_loop_cfg(void)
{
    /* K_p = ω_c·L·I_b/U_b = 3.23933; K_i·T = K_p·314.16/s·T = 0.101767 */
    const pi_cfg_t pi = {.kp = 26537, .ki = 26678, .kp_shift = 13U, .ki_shift = 7U};

    return (current_loop_cfg_t){
        .pi_d = pi,
        .pi_q = pi,
        .reactance_d_q13 = 8293, /* Ω_b·L·I_b/U_b = 1.01229 */
        .reactance_q_q13 = 8293,
        .emf_q13 = 6917,        /* Ω_b·φ/U_b = 0.844303 */
        .resistance_q13 = 1547, /* R·I_b/U_b = 0.188889 */
    };
}

/* 20 Hz, damping 1, ramp 10000 rpm/s; 774 rad/s² electrical per ampere of i_q. */
static inline speed_loop_cfg_t example_speed_loop_cfg(void)
{
    return (speed_loop_cfg_t){
        /*
         * K_p = 2·2π·20/s·2·Ω_b/I_b/774 = 15.9393; K_i·T = (2π·20/s)²·2·Ω_b/I_b/774·1 ms = 1.00149
         */
        .pi = {.kp = 32644, .ki = 16408, .kp_shift = 11U, .ki_shift = 3U},
        .soft = {.kp = 32644, .ki = 16408, .kp_shift = 11U, .ki_shift = 3U},
        .ramp = 143166,        /* 2.0944 rad/s el. a slow period */
        .speed_max = 28633115, /* 2000 rpm */
        .inertia = 32471,      /* 0.0154835 of I_b per step of speed a slow period, times 2^21 */
        .inertia_shift = 5U,
        .inertia_lift = 0U,
        .inertia_least_q13 = 8192, /* J is not corrected */
        .inertia_most_q13 = 8192,
        .inertia_rate = 0,
        .inertia_rate_shift = 0U,
        .error_shift = 12U, /* Q15 of 2·Ω_b */
    };
}

/* 900 rpm, 800 rad/s² mechanical, braking with 720 rad/s². */
static inline position_loop_cfg_t example_position_loop_cfg(void)
{
    return (position_loop_cfg_t){
        .ramp = 109370,        /* 1.6 rad/s el. a slow period */
        .speed_max = 12884902, /* 900 rpm */
        /* B = (94.25 rad/s)²/(2·720 rad/s²) = 1.9635 el. turns = 16085.0 units of 2^19/2^32 turn */
        .braking_inverse = 66754,
        .softness_q15 = 2503, /* 10 ms·720/94.25, times 2^15 */
        .gain = 26354,        /* 2π·5/s·T·2^16 = 205.887, times 2^7 */
        .gain_shift = 7U,
        .distance_shift = 19U,
        .pole_pairs = 2U,
    };
}

/* A sensor with 0 °C at count 0 and 200 °C at 4096: warning at 80 °C, limit at 100 °C. */
static inline derating_cfg_t example_derating_cfg(void)
{
    return (derating_cfg_t){
        .current_max = 8192,        /* 10 A */
        .current_continuous = 5504, /* 6.719 A, rated torque */
        .heat_shift = 2U,           /* 5504² · 4 = 0.90 · 2^27 */
        .heat_gain = 9074,          /* 2^24 · 2^16 / (5504² · 4) */
        .heat_rate = 26844,         /* 4 ms / 20 s · 2^16, times 2^11 */
        .heat_rate_shift = 11U,
        .heat_max_q14 = 19661,                                     /* 1.2 */
        .heat = {.zero = 16384, .gain = 20481, .shift = 10U},      /* from 0.9 to 1: 1638.4 */
        .temperature = {.zero = 2048, .gain = 20481, .shift = 8U}, /* over 409.6 counts */
        .temperature_lowest = 0,                                   /* it may read anything */
        .temperature_highest = 4095,
        .temperature_periods = 25U,
        .bus_high = {.zero = 29127, .gain = 20481, .shift = 11U}, /* from 355 V to 400 V: 3276.8 */
        .bus_low = {.zero = 14564,
                    .gain = -16757,
                    .shift = 10U},    /* from 227.5 V to 200 V: 2002.4 */
        .regeneration_speed = 447392, /* 31.25 rpm */
    };
}

static inline supervision_cfg_t example_supervision_cfg(void)
{
    return (supervision_cfg_t){
        .phase_range_min = 1101,      /* 1.34 A */
        .phase_zero_max = 275,        /* 0.34 A */
        .phase_speed_max = 171798692, /* 0.4 turns a slow period */
        .swing_periods = 76U,         /* 6 / (79 rad/s) */
        .voltage_max = 1296,          /* 0.4·R·10 A + 0.03·310 V = 17.8 V */
        .follow_error_max = 1101,     /* 1.34 A */
        .residual_max = 4128,         /* 5.04 A */
        .mean_shift = 4U,             /* 64 ms */
        .speed_error_max = 7158279,   /* 500 rpm */
        .speed_error_periods = 125U,
        .runaway_periods = 3U,
        .overspeed = 32928083, /* 2300 rpm */
        .overspeed_periods = 5U,
        .stall_current = 2752, /* 3.36 A */
        .stall_speed = 447392, /* 31.25 rpm */
        .stall_periods = 250U,
        .late_max = 10U,
        .sum_max = 228,        /* 1 % of 20 A and 8 LSB of 2^4: 0.278 A */
        .sum_share_q15 = 1966, /* 6 % */
        .late_window = 250U,
    };
}

static inline oscillation_cfg_t example_oscillation_cfg(void)
{
    return (oscillation_cfg_t){
        .act = (uint32_t)OSCILLATION_ACT_FAULT,
        .halves_max = 20U,
        .periods_max = 500U,
        .lag_periods_q4 = 221U, /* 13.8 slow periods */
        .amplitude_max = 1651,  /* 2.02 A */
    };
}

static inline modulator_cfg_t example_modulator_cfg(void)
{
    return (modulator_cfg_t){
        .timer_counts = 8500,   /* 170 MHz / (2·10 kHz) */
        .ratio_max_q15 = 17972, /* 0.95/√3, rounded down */
        .dead_time_q15 = 0,
        .drop_q15 = 0,
        .ripple_q15 = 182, /* 310 V·T/(12·L) = 0.2227 A */
        .edge_slope = 512, /* 8 counts of the converter are 64 LSB */
    };
}

/* 2 µs of dead time and 1.2 V of device drop in each leg. */
static inline modulator_cfg_t example_modulator_cfg_with_dead_time(void)
{
    modulator_cfg_t cfg = example_modulator_cfg();

    cfg.dead_time_q15 = 655; /* 2 µs / T */
    cfg.drop_q15 = 87;       /* 1.2 V / 450 V */
    return cfg;
}

/*
 * Pulses of up to 8 ticks, pauses 8 times as long: 80 ticks are a tenth of the time in which rated
 * torque reaches 2000 rpm.
 */
static inline flying_start_cfg_t example_flying_start_cfg(void)
{
    return (flying_start_cfg_t){
        .current = 410, /* 0.5 A */
        .wait_ticks = 1000U,
        .pulse_ticks = 8U,
        .gap_factor = 8U,
        .pause_max = 80U,
        /*
         * φ/L/I_b = 0.834052, less T·R/(2·L) = 0.00916 of it: 3.96175e-5 LSB a tick per step, times
         * 2^29
         */
        .emf_current = 21270,
        .emf_shift = 13U,
        .decay_q15 = 595, /* T·R/L = 0.018319 */
    };
}

/* In the field of 8 A the rotor swings with 79 rad/s. */
static inline align_cfg_t example_align_cfg(void)
{
    return (align_cfg_t){
        .current_high = 6554, /* 8 A */
        .current_low = 4063,  /* 4.96 A */
        .slope = 65,
        /* the EMF of an eighth of 180 rpm, 1.824 V, over ω_n·φ/(1.4·8 A) = 2.72 ohm */
        .swing_max = 549,
        .sweep_speed = 2111587, /* half a turn in 1017 ticks */
        .sweep_ticks = 1017U,
        .pull_ticks = 3050U,
        .settle_ticks = 763U,
        .measure_log2 = 9U,
        .inductance =
            {
                .pulse_ticks = 3U,
                .pulse_voltage = 6757,  /* 2.4 A·L/(3·T) = 92.8 V */
                .pulse_response = 7864, /* 4·2.4 A */
                .step_ticks = 4U,
                .step_voltage = 6655,  /* 91.4 V */
                .step_response = 2582, /* 91.4 V·4·T/L = 3.151 A */
            },
    };
}

static inline startup_cfg_t example_startup_cfg(void)
{
    return (startup_cfg_t){
        .flying_start = example_flying_start_cfg(),
        .align = example_align_cfg(),
        .current_hold = 6554,
        .current_move = 8192, /* 10 A */
        .current_slope = 65,
        .ramp = 37036,      /* 2587 rpm/s */
        .along_max = 12534, /* 0.85 and 0.45 of 18 A */
        .across_max = 6636,
        .track_speed = 1288490,    /* 90 rpm */
        .handover_speed = 2576980, /* 180 rpm */
        .hold_speed = 1803886,     /* 126 rpm */
        .loaded_speed = 1803886,   /* a load changes nothing */
        .load_current = 826,       /* 15 % of 6.72 A */
        .residual_max = 1638,      /* 2 A */
        .residual_lost = 4915,     /* 6 A */
        .lost_periods = 100U,
        .handover_periods = 100U,
        .attempts = 5U,
    };
}

/* Soft: damps the rotor's swing in the field of 8 A. */
static inline current_loop_cfg_t example_hold_loop_cfg(void)
{
    const pi_cfg_t pi = {.kp = 27682, .ki = 25526, .kp_shift = 19U, .ki_shift = 15U};
    current_loop_cfg_t cfg = example_current_loop_cfg();

    cfg.pi_d = pi;
    cfg.pi_q = pi;
    return cfg;
}

/* All corrections off. */
static inline model_cfg_t example_model_cfg(void)
{
    return (model_cfg_t){
        .flux_rate = 786,          /* 1 ms / 50 ms · I_b/(φ/L), times 2^15 */
        .flux_speed_min = 5153961, /* 360 rpm */
    };
}

/* R by 60 %, L_d by 40 %, L_q/L_d by a factor of 2, φ by 25 %. */
static inline model_cfg_t example_model_cfg_with_corrections(void)
{
    model_cfg_t cfg = example_model_cfg();

    cfg.resistance_limit_q14 = 9830;
    cfg.inductance_limit_q14 = 6554;
    cfg.saliency_limit_q14 = 16384;
    cfg.flux_limit_q14 = 4096;
    return cfg;
}

/* K_p = φ, corner 8/s; g = 0.001, −5° to 40°. */
static inline voltage_drive_cfg_t example_voltage_drive_cfg(void)
{
    return (voltage_drive_cfg_t){
        .enabled = 1U,
        /* φ·2·Ω_b/U_b = 1.68861; times 8/s·1 ms 0.0135089 */
        .pi = {.kp = 27666, .ki = 28331, .kp_shift = 14U, .ki_shift = 10U},
        .speed_min = 3435973, /* 240 rpm */
        .settle_periods = 100U,
        .compensator =
            {
                .gain = 16777, /* 0.001·2^16, times 2^8 */
                .gain_shift = 8U,
                .lead_max = 477218588,
                .brake_max = 59652324,
                .current_min = 1376, /* 1.68 A */
            },
        /* 0.45·ω·L = 1.97 Ω of U_b/I_b at 1800 rpm; 0.6·ω·T */
        .damping = {.resistance_q15 = 5737, .mean_rate_q15 = 741},
    };
}

/*
 * 11.6 N·m in 8 ms, the time of a speed loop of 20 Hz; K_p/K_i of it is 15.9 slow periods. As fast
 * as the speed loop.
 */
static inline torque_loop_cfg_t example_torque_loop_cfg(void)
{
    const step_t speed_max = example_speed_loop_cfg().speed_max;

    return (torque_loop_cfg_t){
        .slope = 7120133,
        .speed_forward = speed_max,
        .speed_backward = speed_max,
        .load_shift = 4U,
    };
}

/* No sensor; what its kinds would need is there. */
static inline sensor_cfg_t example_sensor_cfg(void)
{
    return (sensor_cfg_t){
        .hall = {.patterns =
                     05U | (01U << 3U) | (03U << 6U) | (02U << 9U) | (06U << 12U) | (04U << 15U),
                 .edges_q16 = {0U, 10923U, 21845U, 32768U, 43691U, 54613U},
                 .fast_speed = 0x02000000},
        .encoder = {.counts = 4096, .scale_q32 = 0x100000U},
    };
}

/*
 * Shorts a motor that is faster than this: the gates open once no change over 2 ms was as large for
 * settle_ticks.
 */
static inline safe_state_cfg_t example_safe_state_cfg(step_t open_speed, int32_t change_min,
                                                      uint32_t settle_ticks)
{
    return (safe_state_cfg_t){
        .open_speed = open_speed,
        .span_ticks = 20U,
        .change_min = change_min,
        .settle_ticks = settle_ticks,
    };
}

/* As published: no start-up, the model as it is, no dead time. */
/*
 * A potentiometer from 5 to 95 % of the converter's full scale, with no demand half way; lost
 * within 1 % of the ends, after 0.1 s. Full throttle is the highest speed, after half a second.
 */
static inline input_cfg_t example_input_cfg(void)
{
    return (input_cfg_t){
        .kind = (uint32_t)INPUT_KIND_VOLTAGE,
        .least = 328,
        .low = 1638,
        .middle = 16383,
        .high = 31129,
        .most = 32439,
        .dead_q15 = 983, /* 3 % */
        .expo_q15 = 0,
        .share_q15 = 32767,
        .slope_q30 = 214748, /* 2/s·T, times 2^30 */
        .filter_q15 = 326,   /* 10 ms */
        .timeout_ticks = 1000U,
        .arm_ticks = 5000U,
    };
}

static inline drive_cfg_t example_drive_cfg(void)
{
    drive_cfg_t cfg = {
        .sampling = example_sampling_cfg(),
        .protection = example_protection_cfg(),
        .derating = example_derating_cfg(),
        .supervision = example_supervision_cfg(),
        .oscillation = example_oscillation_cfg(),
        .observer = example_observer_cfg(),
        .current_loop = example_current_loop_cfg(),
        .speed_loop = example_speed_loop_cfg(),
        .position_loop = example_position_loop_cfg(),
        .modulator = example_modulator_cfg(),
        .hold_loop = example_current_loop_cfg(),
        /* 95 % of the largest current, 9.5 of 40 A. */
        .current_reference = {.floor = 0,
                              .floor_shift = 1U,
                              .slope = 65,
                              .slope_down = 2,
                              .most_torque = 1U,
                              .deepest = 7782},
        .model = example_model_cfg(),
        .torque_loop = example_torque_loop_cfg(),
        .sensor = example_sensor_cfg(),
        .speed_shift = 11U,
        .slow_ticks = 10U,
    };

    cfg.crc = config_guard_crc(&cfg);
    return cfg;
}

/* The same with everything that starts it from any angle and corrects its model. */
static inline drive_cfg_t example_drive_cfg_with_startup(void)
{
    drive_cfg_t cfg = example_drive_cfg();

    cfg.observer.rho_max_q13 = 16384;
    cfg.modulator = example_modulator_cfg_with_dead_time();
    cfg.hold_loop = example_hold_loop_cfg();
    cfg.startup = example_startup_cfg();
    cfg.model = example_model_cfg_with_corrections();
    cfg.crc = config_guard_crc(&cfg);
    return cfg;
}

/* Nothing that happens in the course of time is a fault. */
static inline void example_supervise_nothing(drive_cfg_t *cfg)
{
    cfg->derating.heat_rate = 0;
    cfg->derating.temperature.gain = 0;
    cfg->supervision = (supervision_cfg_t){
        .phase_range_min = 65535,
        .phase_speed_max = 1,
        .swing_periods = 1000000U,
        .voltage_max = 32767,
        .follow_error_max = 65535,
        .residual_max = 8191,
        .mean_shift = 14U,
        .speed_error_max = 0x40000000,
        .runaway_periods = 1000000U,
        .overspeed = 0x40000000,
        .stall_current = 16384,
        .stall_speed = 1,
        .stall_periods = 1000000U,
        .late_max = 1000000U,
        .sum_max = 1,
        .sum_share_q15 = 0,
        .late_window = 1U,
    };
    cfg->oscillation.act = (uint32_t)OSCILLATION_ACT_NONE;
    cfg->crc = config_guard_crc(cfg);
}

#endif
