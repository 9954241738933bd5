// SPDX-License-Identifier: MIT
#include "demands.h"

#include "bases.h"
#include "numbers.h"
#include "plate.h"

#include <memory>

extern "C" {
#include "identify_aim.h"
#include "identify_rest.h"
#include "identify_turn.h"
}

namespace nf::identify
{
namespace
{

constexpr double SWINGS =
    4.0 / 3; // of the speed of the vector: as the firmware says it (identify.c)

} // namespace

Demands demands_of(const Config &plate)
{
    const Config assumed = with_typical(plate);
    const drive_cfg_t cfg = build(assumed);
    const Bases bases = make_bases(assumed.motor, assumed.board);
    const auto app = std::make_unique<app_t>();
    app->drive.cfg = &cfg;
    identify_t at_first{};
    at_first.app = app.get();
    const double ampere = bases.current_a / Q15;
    return {identify_aim_continuous(&at_first) * ampere, identify_rest_largest(&at_first) * ampere,
            bases.rpm_from_step(identify_turn_speed(&at_first)) * SWINGS};
}

} // namespace nf::identify
