/* SPDX-License-Identifier: MIT */
// The design of paper B as it is shipped, and its two models.
#pragma once

#include "study.h"

#include "testing.h"

namespace test
{

using namespace nf::design;

inline const DesignSettings &shipped()
{
    static const DesignSettings settings = read_design("motor_b");
    return settings;
}

inline const Discrete &model(const char *name)
{
    static const std::vector<Model> models = make_models(shipped());
    for (const Model &m : models) {
        if (m.name == name) {
            return m.discrete;
        }
    }
    TEST_FAIL_MESSAGE("no such model");
    return models.front().discrete;
}

inline const Discrete &computed()
{
    return model("computed");
}

inline const Discrete &printed()
{
    return model("printed");
}

constexpr Gains PUBLISHED = {0.264, 0.035};
constexpr Gains OTHER_SIGN = {0.264, -0.035};
constexpr Gains ARBITRARY = {0.04, 0.0001};

} // namespace test
