// SPDX-License-Identifier: MIT
#include "study.h"

#include "discretise.h"

#include <fmt/format.h>

namespace nf::design
{
namespace
{

constexpr int REGION_POINTS = 161;

std::string name_of(const Model &model, const std::string &pair)
{
    return fmt::format("{} matrices, {}", model.name, pair);
}

std::string start_name(const DesignSettings &settings, const Model &model)
{
    return name_of(model, "start") +
           (settings.foreign_nominal
                ? fmt::format(" (nominal.* is that of the design's own motor, it "
                              "must be that of {})",
                              settings.inputs.motor.name)
                : "");
}

} // namespace

std::vector<Model> make_models(const DesignSettings &settings)
{
    const Machine machine = make_machine(settings.inputs.motor, settings.nominal.inertia_kg_m2);
    const Continuous continuous = linearise(machine, settings.nominal);
    std::vector<Model> models = {
        {"computed", discretise(continuous, settings.nominal.sample_time_s), {}}};
    if (!settings.matrices.empty()) {
        PrintedMatrices printed = read_matrices(settings.matrices);
        models.push_back({"printed", printed.model, std::move(printed.corrections)});
    }
    return models;
}

ModelStudy study(const DesignSettings &settings, const Model &model)
{
    const Discrete &motor = model.discrete;
    const OptimumSettings &o = settings.optimum;
    ModelStudy s;
    s.model = model;
    require_stable(motor, o.start, start_name(settings, model));
    s.optimum = stable_optimum(motor, o.cost, o.start, o.slowest_time_constant_s);
    s.free = free_optimum(motor, o.cost, o.start);
    s.region = stable_region(motor, s.optimum.gains.kp, REGION_POINTS);
    s.largest_ki_per_s = largest_ki_per_s(motor, settings.published.kp);
    s.pairs = {{"arbitrary", settings.arbitrary},
               {"published", settings.published},
               {"optimum", s.optimum.gains}};
    for (const Pair &pair : s.pairs) {
        require_stable(motor, pair.gains, name_of(model, pair.name));
        for (const int input : {LOAD, SUPPLY}) {
            Response response =
                step_response(motor, pair.gains, settings.nominal.k2, input, settings.response_s);
            const ResponseFigures f = figures(motor, pair.gains, input, response);
            s.responses.push_back(
                {pair.name, input, std::move(response), f, settled(motor, pair.gains, input)});
        }
    }
    return s;
}

} // namespace nf::design
