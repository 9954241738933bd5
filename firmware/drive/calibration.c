/* SPDX-License-Identifier: MIT */
#include "calibration.h"

/* largest possible zero, Q15 of I_b: the upper end of the converter's range */
#define OFFSET_END (32768)
/* bound on the sums: 2^12 samples of 16 bits */
#define OFFSET_SUM_MAX (0x10000000)

/* Returns the mean of 2^offset_log2 raw samples, Q15 of I_b. */
static int32_t mean_sample(const sampling_cfg_t *cfg, int32_t sum)
{
    const uint64_t scaled = (uint64_t)sum << cfg->current_shift;
    const uint64_t mean = scaled >> cfg->offset_log2;

    return (mean < (uint64_t)OFFSET_END) ? (int32_t)mean : OFFSET_END;
}

static drive_event_t finish_calibration(sensors_t *sensors, const drive_cfg_t *cfg, fault_t *fault)
{
    fault_id_t id;

    sensors->offset_a = mean_sample(&cfg->sampling, sensors->sums.sum_a);
    sensors->offset_b = mean_sample(&cfg->sampling, sensors->sums.sum_b);
    id = protection_check_offset(&cfg->protection, sensors->offset_a - CALIBRATION_NOMINAL_Q15,
                                 sensors->offset_b - CALIBRATION_NOMINAL_Q15, fault);
    return (id == FAULT_NONE) ? DRIVE_EVENT_CALIBRATED : DRIVE_EVENT_FAULT;
}

/* Adds the changes since the last sample. Without current only noise changes a sample. */
static void count_noise(calibration_t *sums, const drive_in_t *in)
{
    const int32_t a = (int32_t)in->adc_ia - (int32_t)sums->before_a;
    const int32_t b = (int32_t)in->adc_ib - (int32_t)sums->before_b;

    if (sums->samples > 0U) {
        sums->noise = fx_min(sums->noise + fx_abs(a) + fx_abs(b), OFFSET_SUM_MAX);
    }
    sums->before_a = in->adc_ia;
    sums->before_b = in->adc_ib;
}

drive_event_t calibration_step(sensors_t *sensors, const drive_cfg_t *cfg, const drive_in_t *in,
                               fault_t *fault)
{
    calibration_t *const sums = &sensors->sums;
    drive_event_t event = DRIVE_EVENT_NONE;

    sums->sum_a = fx_min(sums->sum_a + (int32_t)in->adc_ia, OFFSET_SUM_MAX);
    sums->sum_b = fx_min(sums->sum_b + (int32_t)in->adc_ib, OFFSET_SUM_MAX);
    count_noise(sums, in);
    sums->samples++;
    if (sums->samples == (1UL << cfg->sampling.offset_log2)) {
        event = finish_calibration(sensors, cfg, fault);
    }
    return event;
}

void calibration_begin(sensors_t *sensors)
{
    sensors->sums = (calibration_t){.sum_a = 0};
}

void calibration_keep(sensors_t *sensors, const sensors_t *before)
{
    sensors->offset_a = before->offset_a;
    sensors->offset_b = before->offset_b;
}
