#!/bin/sh
# format.sh: every C and C++ source and header is as clang-format 14 writes it with .clang-format.
# Exit status 77 (skipped) where there is no clang-format 14: other versions differ in details.
set -eu
cd "$(dirname "$0")/.."
format=clang-format
if command -v clang-format-14 >/dev/null; then
  format=clang-format-14
fi
case $("$format" --version 2>/dev/null) in
*" version 14."*) ;;
*) echo "no clang-format 14"; exit 77 ;;
esac
find src calib include tests -name '*.[ch]' -o -name '*.cpp' | sort |
  xargs "$format" --style=file --dry-run -Werror
