/* SPDX-License-Identifier: MIT */
#include "semihost.h"

/* Operations and the reason "application exit" of the semihosting specification. */
#define SYS_OPEN (0x01U)
#define SYS_CLOSE (0x02U)
#define SYS_WRITE0 (0x04U)
#define SYS_WRITE (0x05U)
#define SYS_READ (0x06U)
#define SYS_EXIT_EXTENDED (0x20U)
#define STOPPED_APPLICATION_EXIT (0x20026U)

/*
 * Implemented in semihost_call.S. The arguments after the first are the block of the operation;
 * SYS_WRITE0 takes the text itself.
 */
int32_t semihost_call_open(uint32_t operation, const char *name, uint32_t mode, uint32_t length);
int32_t semihost_call_read(uint32_t operation, int32_t handle, uint8_t *to, uint32_t bytes);
int32_t semihost_call_write(uint32_t operation, int32_t handle, const uint8_t *from,
                            uint32_t bytes);
int32_t semihost_call_close(uint32_t operation, int32_t handle);
int32_t semihost_call_print(uint32_t operation, const char *text);
int32_t semihost_call_exit(uint32_t operation, uint32_t reason, uint32_t code);

int32_t semihost_open(const char *name, uint32_t length, semihost_mode_t mode)
{
    return semihost_call_open(SYS_OPEN, name, (uint32_t)mode, length);
}

bool semihost_read(int32_t handle, uint8_t *to, uint32_t bytes)
{
    /* The answer is the number of bytes that are still missing. */
    return semihost_call_read(SYS_READ, handle, to, bytes) == 0;
}

bool semihost_write(int32_t handle, const uint8_t *from, uint32_t bytes)
{
    return semihost_call_write(SYS_WRITE, handle, from, bytes) == 0;
}

bool semihost_close(int32_t handle)
{
    return semihost_call_close(SYS_CLOSE, handle) == 0;
}

void semihost_print(const char *text)
{
    (void)semihost_call_print(SYS_WRITE0, text);
}

void semihost_exit(uint32_t code)
{
    for (;;) {
        (void)semihost_call_exit(SYS_EXIT_EXTENDED, STOPPED_APPLICATION_EXIT, code);
    }
}
