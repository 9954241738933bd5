#include "recording.h"

#include <stddef.h>

#define FNV_BASIS (2166136261U)
#define FNV_PRIME (16777619U)

static void put8(uint8_t **to, uint32_t value)
{
    **to = (uint8_t)(value & 0xFFU);
    (*to)++;
}

static void put16(uint8_t **to, uint32_t value)
{
    put8(to, value);
    put8(to, value >> 8U);
}

static void put32(uint8_t **to, uint32_t value)
{
    put16(to, value);
    put16(to, value >> 16U);
}

static uint8_t get8(const uint8_t **from)
{
    const uint8_t value = **from;

    (*from)++;
    return value;
}

static uint16_t get16(const uint8_t **from)
{
    const uint32_t low = get8(from);
    const uint32_t high = get8(from);

    return (uint16_t)(low | (high << 8U));
}

static uint32_t get32(const uint8_t **from)
{
    const uint32_t low = get16(from);
    const uint32_t high = get16(from);

    return low | (high << 16U);
}

recording_header_t recording_header(uint32_t magic, uint32_t config_hash, uint32_t ticks)
{
    const uint32_t bytes =
        (magic == RECORDING_FRAMES) ? RECORDING_FRAME_BYTES : RECORDING_RESULT_BYTES;

    return (recording_header_t){
        .magic = magic,
        .version = RECORDING_VERSION,
        .record_bytes = (uint16_t)bytes,
        .config_hash = config_hash,
        .ticks = ticks,
    };
}

void recording_put_header(uint8_t *to, const recording_header_t *header)
{
    uint8_t *at = to;

    put32(&at, header->magic);
    put16(&at, header->version);
    put16(&at, header->record_bytes);
    put32(&at, header->config_hash);
    put32(&at, header->ticks);
}

recording_header_t recording_get_header(const uint8_t *from)
{
    const uint8_t *at = from;
    recording_header_t header;

    header.magic = get32(&at);
    header.version = get16(&at);
    header.record_bytes = get16(&at);
    header.config_hash = get32(&at);
    header.ticks = get32(&at);
    return header;
}

const char *recording_refuse(const recording_header_t *header, uint32_t config_hash)
{
    const char *why = NULL;

    if (header->magic != RECORDING_FRAMES) {
        why = "this is no recording of input frames\n";
    } else if ((header->version != RECORDING_VERSION) ||
               (header->record_bytes != RECORDING_FRAME_BYTES)) {
        why = "the recording has another version\n";
    } else if (header->config_hash != config_hash) {
        why = "the recording was made with another configuration\n";
    } else {
        /* as it should be */
    }
    return why;
}

void recording_put_frame(uint8_t *to, const drive_in_t *in)
{
    uint8_t *at = to;

    put16(&at, in->adc_ia);
    put16(&at, in->adc_ib);
    put16(&at, in->adc_bus);
    put16(&at, in->adc_temperature);
    put16(&at, in->angle);
    put16(&at, in->flags);
    put32(&at, (uint32_t)in->command.target);
    put8(&at, in->command.mode);
    put8(&at, in->command.request);
}

drive_in_t recording_get_frame(const uint8_t *from)
{
    const uint8_t *at = from;
    drive_in_t in;

    in.adc_ia = get16(&at);
    in.adc_ib = get16(&at);
    in.adc_bus = get16(&at);
    in.adc_temperature = get16(&at);
    in.angle = get16(&at);
    in.flags = get16(&at);
    in.command.target = (int32_t)get32(&at);
    in.command.mode = get8(&at);
    in.command.request = get8(&at);
    return in;
}

void recording_put_result(uint8_t *to, const drive_out_t *out, const drive_t *drive)
{
    uint8_t *at = to;

    put16(&at, out->compare.phase[0]);
    put16(&at, out->compare.phase[1]);
    put16(&at, out->compare.phase[2]);
    put8(&at, out->gate_enable ? 1U : 0U);
    put8(&at, (uint32_t)drive->state);
    put32(&at, recording_state_hash(drive));
}

static uint32_t mix8(uint32_t hash, uint32_t byte)
{
    return (hash ^ (byte & 0xFFU)) * FNV_PRIME;
}

static void mix_u32(uint32_t *hash, uint32_t word)
{
    uint32_t h = *hash;

    h = mix8(h, word);
    h = mix8(h, word >> 8U);
    h = mix8(h, word >> 16U);
    *hash = mix8(h, word >> 24U);
}

static void mix_i32(uint32_t *hash, int32_t word)
{
    mix_u32(hash, (uint32_t)word);
}

static void mix_i64(uint32_t *hash, int64_t value)
{
    const uint64_t bits = (uint64_t)value;

    mix_u32(hash, (uint32_t)(bits & 0xFFFFFFFFU));
    mix_u32(hash, (uint32_t)(bits >> 32U));
}

static void mix_dq(uint32_t *hash, dq_t v)
{
    mix_i32(hash, v.d);
    mix_i32(hash, v.q);
}

static void mix_ab(uint32_t *hash, ab_t v)
{
    mix_i32(hash, v.alpha);
    mix_i32(hash, v.beta);
}

static void mix_fault(uint32_t *hash, const fault_t *fault)
{
    mix_u32(hash, (uint32_t)fault->id);
    mix_i32(hash, fault->value);
    mix_i32(hash, fault->limit);
    mix_u32(hash, fault->tick);
}

static void mix_observer(uint32_t *hash, const nn_observer_t *obs)
{
    mix_i32(hash, obs->alpha_q27);
    mix_i32(hash, obs->beta_q27);
    mix_dq(hash, obs->state);
    mix_i32(hash, obs->speed);
    mix_i32(hash, obs->speed_out);
    mix_i32(hash, obs->weight_step);
    mix_dq(hash, obs->current);
    mix_dq(hash, obs->error);
    mix_dq(hash, obs->turned);
    mix_i32(hash, obs->descent);
    mix_i32(hash, obs->rho_q13);
}

/* The parts of the configuration that the model in force holds have no padding: 32-bit fields. */
static void mix_bytes(uint32_t *hash, const uint8_t *from, size_t bytes)
{
    uint32_t h = *hash;

    for (size_t k = 0U; k < bytes; k++) {
        h = mix8(h, from[k]);
    }
    *hash = h;
}

static void mix_model(uint32_t *hash, const model_t *model)
{
    mix_bytes(hash, (const uint8_t *)&model->observer, sizeof(model->observer));
    mix_bytes(hash, (const uint8_t *)&model->run_loop, sizeof(model->run_loop));
    mix_bytes(hash, (const uint8_t *)&model->hold_loop, sizeof(model->hold_loop));
    mix_i32(hash, model->resistance_q14);
    mix_i32(hash, model->inductance_q14);
    mix_i32(hash, model->inductance_inverse_q14);
    mix_i32(hash, model->flux_q30);
}

static void mix_catch_spin(uint32_t *hash, const catch_spin_t *spin)
{
    mix_u32(hash, spin->tick);
    mix_u32(hash, spin->phase);
    mix_u32(hash, spin->length);
    mix_ab(hash, spin->first);
    mix_u32(hash, spin->gates ? 1U : 0U);
    mix_i32(hash, spin->speed);
    mix_u32(hash, spin->angle);
}

static void mix_align(uint32_t *hash, const align_t *align)
{
    mix_u32(hash, (uint32_t)align->phase);
    mix_u32(hash, align->tick);
    mix_u32(hash, align->backwards ? 1U : 0U);
    mix_i32(hash, align->current_ref);
    mix_i32(hash, align->frame_speed);
    mix_i32(hash, align->step_start);
    mix_i32(hash, align->step_fall);
    mix_i32(hash, align->high.voltage);
    mix_i32(hash, align->high.current);
    mix_i32(hash, align->low.voltage);
    mix_i32(hash, align->low.current);
}

static void mix_low_speed(uint32_t *hash, const drive_t *drive)
{
    mix_u32(hash, drive->identified ? 1U : 0U);
    mix_i64(hash, drive->frame.turns_q32);
    mix_i32(hash, drive->frame_speed);
    mix_i32(hash, drive->residual);
    mix_u32(hash, drive->lost_periods);
    mix_u32(hash, drive->handover_periods);
    mix_u32(hash, drive->attempts);
    mix_catch_spin(hash, &drive->catch_spin);
    mix_align(hash, &drive->align);
}

static void mix_loops(uint32_t *hash, const drive_t *drive)
{
    mix_i32(hash, drive->current_loop.pi_d.integral_q26);
    mix_i32(hash, drive->current_loop.pi_q.integral_q26);
    mix_i32(hash, drive->speed_loop.pi.integral_q26);
    mix_i32(hash, drive->speed_loop.reference);
    mix_i64(hash, drive->position_loop.profile_q32);
    mix_i32(hash, drive->position_loop.profile_speed);
}

static void mix_voltage_drive(uint32_t *hash, const drive_t *drive)
{
    mix_u32(hash, drive->voltage_driven ? 1U : 0U);
    mix_u32(hash, drive->compensator.angle);
    mix_i32(hash, drive->compensator.current_angle);
    mix_i32(hash, drive->voltage_magnitude);
}

static void mix_derating(uint32_t *hash, const derating_t *derating)
{
    mix_i32(hash, derating->heat_q24);
    mix_i32(hash, derating->thermal);
    mix_u32(hash, derating->too_hot);
    mix_i32(hash, derating->motoring);
    mix_i32(hash, derating->braking);
    mix_u32(hash, derating->flags_slow);
    mix_u32(hash, derating->flags);
}

static void mix_supervision(uint32_t *hash, const supervision_t *s)
{
    mix_u32(hash, s->step);
    mix_u32(hash, s->late);
    mix_u32(hash, s->late_periods);
    mix_i32(hash, s->start_q16);
    mix_u32(hash, s->samples);
    for (uint32_t phase = 0U; phase < SUPERVISION_PHASES; phase++) {
        mix_i32(hash, s->lowest[phase]);
        mix_i32(hash, s->highest[phase]);
    }
    mix_u32(hash, s->weak);
    mix_u32(hash, s->weak_arcs);
    mix_u32(hash, s->absent);
    mix_u32(hash, s->absent_periods);
    mix_u32(hash, s->unexplained);
    mix_fault(hash, &s->suspect);
    mix_dq(hash, s->off_current);
    mix_u32(hash, s->off_reference);
    mix_u32(hash, s->runaway);
    mix_u32(hash, s->too_fast);
    mix_u32(hash, s->stalled);
    mix_i32(hash, s->residual);
}

static void mix_signals(uint32_t *hash, const drive_signals_t *s)
{
    mix_i32(hash, s->phase_a);
    mix_i32(hash, s->phase_b);
    mix_i32(hash, s->bus);
    mix_ab(hash, s->current_ab);
    mix_dq(hash, s->current);
    mix_dq(hash, s->current_frame);
    mix_dq(hash, s->current_mean);
    mix_ab(hash, s->voltage_applied);
    mix_i32(hash, s->speed);
    mix_dq(hash, s->current_ref);
    mix_i32(hash, s->voltage_limit);
    mix_dq(hash, s->voltage);
    mix_ab(hash, s->ratio_ab);
}

uint32_t recording_state_hash(const drive_t *drive)
{
    uint32_t hash = FNV_BASIS;

    mix_u32(&hash, (uint32_t)drive->state);
    mix_fault(&hash, &drive->fault);
    mix_u32(&hash, drive->tick);
    mix_i32(&hash, drive->limits.current_max);
    mix_i32(&hash, drive->limits.bus_max);
    mix_i32(&hash, drive->limits.bus_min);
    mix_i32(&hash, drive->offset_a);
    mix_i32(&hash, drive->offset_b);
    mix_u32(&hash, drive->offset_samples);
    mix_u32(&hash, drive->slow_count);
    mix_u32(&hash, drive->mode);
    mix_observer(&hash, &drive->observer);
    mix_i64(&hash, drive->position.turns_q32);
    mix_loops(&hash, drive);
    mix_i32(&hash, drive->speed_reference);
    mix_i32(&hash, drive->modulator.inverse_bus_q12);
    mix_ab(&hash, drive->ratio_acting);
    mix_i32(&hash, drive->bus_before);
    mix_signals(&hash, &drive->signals);
    mix_i32(&hash, drive->torque_range.lower);
    mix_i32(&hash, drive->torque_range.upper);
    mix_derating(&hash, &drive->derating);
    mix_supervision(&hash, &drive->supervision);
    mix_u32(&hash, drive->guard.at);
    mix_u32(&hash, drive->guard.crc);
    mix_model(&hash, &drive->model);
    mix_low_speed(&hash, drive);
    mix_voltage_drive(&hash, drive);
    return hash;
}

uint32_t recording_config_hash(const drive_cfg_t *cfg)
{
    uint32_t hash = FNV_BASIS;

    mix_bytes(&hash, (const uint8_t *)cfg, sizeof(*cfg));
    return hash;
}
