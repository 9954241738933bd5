/* Tables behind trig.c. Generated values, see tools/gen_trig_table.py. Private to firmware/math. */
#ifndef TRIG_TABLE_H
#define TRIG_TABLE_H

#include <stdint.h>

#define TRIG_SIN_BITS (10U)     /* log2 of the entries a turn */
#define TRIG_SIN_QUARTER (256U) /* entries a quarter turn */

/* round(32767·sin(2π·k / 1024)), k = 0…1280: one turn, a quarter more for the cosine, one to the right. */
extern const int16_t trig_sin_table[1281];

#define TRIG_ATAN_BITS (8U)
#define TRIG_ATAN_SIZE (256U)

/* round(2^16·atan(k / 256) / (π/4)), k = 0…256, the last entry limited to 65535. */
extern const uint16_t trig_atan_table[257];

#endif
