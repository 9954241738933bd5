# For IDEs that start gdb in the project's folder; gdb reads it where it was told to trust it.
source tools/gdb/neurofoc.py
