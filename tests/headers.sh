# headers.sh CC [CXX]: every header under include/ stands alone, as C11 and as C++17.
set -eu
cc=$1
cxx=${2:-}
strict="-Wall -Wextra -Wpedantic -Wshadow -Wconversion -Werror -Iinclude -fsyntax-only"
for header in include/halflight/*.h; do
  name=${header#include/}
  echo "$name"
  # shellcheck disable=SC2086
  printf '#include "%s"\n#include "%s"\nint unused;\n' "$name" "$name" |
    "$cc" -std=c11 $strict -Wstrict-prototypes -x c -
  if [ -n "$cxx" ]; then
    # shellcheck disable=SC2086
    printf '#include "%s"\n#include "%s"\n' "$name" "$name" | "$cxx" -std=c++17 $strict -x c++ -
  fi
done
