/* SPDX-License-Identifier: MIT */
/* What is wrong with a sensor of the shaft, as its decoder names it. */
#ifndef SHAFT_TROUBLE_H
#define SHAFT_TROUBLE_H

/* The numbers are part of recordings, so new ones go to the end. */
typedef enum {
    SHAFT_TROUBLE_NONE = 0,
    SHAFT_TROUBLE_HALL_PATTERN, /* a pattern that no angle has; which signal is wrong is unknown */
    SHAFT_TROUBLE_HALL_SIGNAL,  /* one signal stands still; the other two tell the angle */
    SHAFT_TROUBLE_HALL_JUMP,    /* the pattern has passed over a sector */
    SHAFT_TROUBLE_COUNTS,       /* an encoder has lost or gained counts since its last index */
    SHAFT_TROUBLE_INDEX,        /* an index of an encoder came at a wrong place, or did not come */
    SHAFT_TROUBLE_FRAME,        /* a frame of an absolute sensor has a wrong parity or jumps */
    SHAFT_TROUBLE_FLAGGED,      /* an absolute sensor reports an error of its own */
    SHAFT_TROUBLE_TURNED,       /* the EMF shows the rotor more than a quarter turn off the angle */
    SHAFT_TROUBLES              /* number of entries, not a trouble */
} shaft_trouble_t;

#endif
