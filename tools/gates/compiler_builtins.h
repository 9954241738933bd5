/* SPDX-License-Identifier: MIT */
/* For a checker, which does not know them: functions that the compiler declares itself. */
int __builtin_clz(unsigned int x);
int __builtin_arm_ssat(int x, unsigned int bits);
int __builtin_arm_usat(int x, unsigned int bits);
int __builtin_arm_smlawb(int a, int b, int sum);
void __atomic_signal_fence(int order);
