// SPDX-License-Identifier: MIT
#include "list_command.h"

#include "data_list.h"
#include "ending.h"
#include "peer.h"
#include "program.h"

#include <nlohmann/json.hpp>

namespace nf::commands
{

int list()
{
    write_text("-", data_list_text());
    return LIMITS_HOLD;
}

int estimators()
{
    nlohmann::ordered_json json;
    for (const peers::Peer &peer : peers::all()) {
        nlohmann::ordered_json &entry = json[peer.name];
        entry["title"] = peer.title;
        for (const peers::Gain &gain : peer.gains) {
            entry["gain"][gain.name] = {{"min", gain.min}, {"max", gain.max}, {"help", gain.help}};
        }
    }
    write_text("-", json.dump(2) + '\n');
    return LIMITS_HOLD;
}

} // namespace nf::commands
