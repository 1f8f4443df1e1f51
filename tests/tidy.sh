#!/bin/sh
# tidy.sh BUILD: clang-tidy over every C source that BUILD compiles, with .clang-tidy. BUILD was
# configured with -DCMAKE_EXPORT_COMPILE_COMMANDS=ON. The bridges are C++ and other libraries'
# headers reach into them, so they are not looked at.
set -eu
cd "$(dirname "$0")/.."
build=$1
tidy=clang-tidy
if command -v clang-tidy-14 >/dev/null; then
  tidy=clang-tidy-14
fi
find src calib tests -name '*.c' ! -name 'bridge_*' ! -path 'tests/bench/*' ! -path 'tests/consumer/*' |
  sort >"$build/tidy.files"
# what this build leaves out has no command in the list
while IFS= read -r file; do
  grep -qF "/$file\"" "$build/compile_commands.json" && echo "$file"
done <"$build/tidy.files" | xargs -n 1 -P 2 "$tidy" --quiet -p "$build" >"$build/tidy.found" 2>"$build/tidy.said" &&
  exit 0
cat "$build/tidy.found"
grep -v ' warnings\{0,1\} generated' "$build/tidy.said" || true
grep -E ' (error|warning): ' "$build/tidy.found" | sort -u # once more, where nobody overlooks it
exit 1
