/* SPDX-License-Identifier: MIT */
/*
 * A list of rules about a configuration. The first broken rule is reported. For use within
 * firmware/config.
 */
#ifndef CONFIG_RULE_H
#define CONFIG_RULE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct {
    const char *path; /* path of the setting that the rule is about, a constant string */
    bool broken;
} config_rule_t;

#define CONFIG_RULES(rules) ((uint32_t)(sizeof(rules) / sizeof((rules)[0])))

/* Returns the path of the first broken rule; NULL: there is none. Pure, any context. */
static inline const char *config_rule_broken(const config_rule_t *rules, uint32_t count)
{
    const char *path = NULL;

    for (uint32_t k = 0U; (k < count) && (path == NULL); k++) {
        if (rules[k].broken) {
            path = rules[k].path;
        }
    }
    return path;
}

#endif
