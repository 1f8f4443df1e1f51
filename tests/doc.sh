# doc.sh VERSION: the API reference is made without a complaint, and a docstring that is wrong is one.
set -eu
if ! command -v doxygen > /dev/null; then
  echo "skipped: no doxygen; the package doxygen is needed"
  exit 77
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
sh src/doc/reference.sh "$work/good" "$1"
mkdir "$work/tree"
cp -r include src "$work/tree"
sed -i 's/@param settings /@param fame /' "$work/tree/include/halflight/light.h"
if sh "$work/tree/src/doc/reference.sh" "$work/bad" "$1" > "$work/said"; then
  echo "a parameter that does not exist was let through"
  exit 1
fi
grep -q "fame" "$work/said"
printf '\nHL_API void hl_unexplained(int value);\n' >> "$work/tree/include/halflight/vec3.h"
cp include/halflight/light.h "$work/tree/include/halflight/"
if sh "$work/tree/src/doc/reference.sh" "$work/bad" "$1" > "$work/said"; then
  echo "a function without a docstring was let through"
  exit 1
fi
grep -q hl_unexplained "$work/said"
