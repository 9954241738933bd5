/* SPDX-License-Identifier: MIT */
/*
 * Files and exit code of the machine that runs the emulator (or the debugger), as Arm's semihosting
 * specification defines them. Each call stops the core until the host has carried it out.
 */
#ifndef SEMIHOST_H
#define SEMIHOST_H

#include <stdbool.h>
#include <stdint.h>

typedef enum {
    SEMIHOST_READ = 1,  /* "rb" */
    SEMIHOST_WRITE = 5, /* "wb": the file is made anew */
} semihost_mode_t;

/*
 * Opens a file in the host's working folder. Returns its handle, or −1. length: number of
 * characters of the name, without the zero at its end.
 */
int32_t semihost_open(const char *name, uint32_t length, semihost_mode_t mode);

/* True when all bytes were read/written. */
bool semihost_read(int32_t handle, uint8_t *to, uint32_t bytes);
bool semihost_write(int32_t handle, const uint8_t *from, uint32_t bytes);

/* True when everything written has reached the file. */
bool semihost_close(int32_t handle);

/* Shows one line to the host's user. text: ends in \n. */
void semihost_print(const char *text);

/* Ends the emulation with this exit code, 0…255. Does not return. Context: any. */
void semihost_exit(uint32_t code);

#endif
