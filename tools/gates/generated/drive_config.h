/* Stands for what nfconfig makes of a board's files: gate.misra reads the sources without a build. */
#ifndef DRIVE_CONFIG_H
#define DRIVE_CONFIG_H

#define DRIVE_RECORDER_ENTRIES (352U)

#endif
