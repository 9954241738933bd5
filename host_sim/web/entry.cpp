// SPDX-License-Identifier: MIT
#include "calls.h"

// Both texts are UTF-8 with an end. The answer is good until the next call.
extern "C" const char *nf_web_call(const char *name, const char *given);

const char *nf_web_call(const char *name, const char *given)
{
    static std::string last;
    last = nf::web::answer(name, given);
    return last.c_str();
}
