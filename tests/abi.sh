# abi.sh CC [update [unreleased]]: what programs are compiled against is as tests/abi.txt lists it.
#
# The list holds the SOVERSION, every exported function with its types, every enumerator and macro of
# a number with its value, every struct with its size, and the offset of its members (x86-64; elsewhere
# the functions and values alone are compared). Who changes the API on purpose writes it anew with
# `update`. A line that is only added keeps old programs running: raise the version. One that changed
# or went breaks them: `update` refuses until SOVERSION in CMakeLists.txt is another than the list's,
# unless `unreleased` says that no release had that line.
set -eu
cc=$1 update=${2:-} unreleased=${3:-}
list=tests/abi.txt
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export LC_ALL=C

headers=$(grep -L 'Internal, not installed' include/halflight/*.h)
for header in $headers; do
  echo "#include \"${header#include/}\""
done > "$work/all.h"
# one declaration a line
"$cc" -std=c11 -E -P -Iinclude "$work/all.h" | tr '\n' ' ' | sed 's/  */ /g; s/__attribute__((visibility("default")))/\nHL_API/g' \
  > "$work/flat"
sed -n 's/^HL_API \([^;]*\) *;.*/\1/p' "$work/flat" |
  sed 's/ *__attribute__.*//; s/\([(*]\) /\1/g; s/ \([),]\)/\1/g; s/^/function /' | sort > "$work/functions"

{
  echo '#include <stddef.h>'
  echo '#include <stdio.h>'
  cat "$work/all.h"
  echo 'int main(void) {'
  tr '\n' ' ' < "$work/flat" | grep -oE 'enum( hl_[a-z_]+)? \{[^}]*\}' | sed 's/.*{//; s/}//' | tr ',' '\n' |
    sed -n 's/^ *\(HL_[A-Z0-9_]*\).*/printf("value \1 %d\\n", (int)\1);/p'
  # a struct's members by name: brackets, pointers and types left out, functions kept
  tr '\n' ' ' < "$work/flat" | grep -oE 'typedef struct hl_[a-z0-9_]+ \{[^}]*\} hl_[a-z0-9_]+;' |
    awk '{
      name = $0
      sub(/.*[}] /, "", name)
      sub(/;/, "", name)
      printf "printf(\"struct %s %%zu\\n\", sizeof(%s));\n", name, name
      sub(/^[^{]*[{]/, "")
      sub(/[}].*/, "")
      while (match($0, /\(\*[a-z_0-9]*\)\([^)]*\)/)) { # a pointer to a function
        inner = substr($0, RSTART + 2, RLENGTH)
        sub(/\).*/, "", inner)
        $0 = substr($0, 1, RSTART - 1) " " inner substr($0, RSTART + RLENGTH)
      }
      gsub(/\[[^]]*\]/, "")
      n = split($0, declared, /[;,]/)
      for (i = 1; i <= n; i++)
        if (match(declared[i], /[A-Za-z_][A-Za-z_0-9]* *$/)) {
          member = substr(declared[i], RSTART)
          gsub(/ /, "", member)
          printf "printf(\"member %s.%s %%zu %%zu\\n\", offsetof(%s, %s), sizeof(((%s *)0)->%s));\n", \
            name, member, name, member, name, member
        }
    }'
  echo 'return 0; }'
} > "$work/sizes.c"
"$cc" -std=c11 -Iinclude -o "$work/sizes" "$work/sizes.c"
"$work/sizes" | sort > "$work/layout"
soversion=$(sed -n 's/.*SOVERSION \([0-9]*\).*/\1/p' CMakeLists.txt)
{
  echo "soversion $soversion"
  cat "$work/functions" "$work/layout"
} > "$work/now"
for kind in function value struct member; do
  test "$(grep -c "^$kind " "$work/now")" -gt 20 || { echo "hardly any $kind found"; exit 1; }
done
functions=$(cat include/halflight/*.h | tr '\n' ' ' | grep -oE 'HL_API [^;(]*\bhl_[a-z0-9_]+\(' | wc -l)
internal=$(grep -l 'Internal, not installed' include/halflight/*.h | xargs cat | grep -c '^HL_API' || true)
test "$(wc -l < "$work/functions")" = $((functions - internal)) ||
  { echo "$(wc -l < "$work/functions") functions listed, the headers name $((functions - internal))"; exit 1; }

if [ "$update" = update ]; then
  before=$(sed -n 's/^soversion //p' "$list" 2> /dev/null || true)
  if [ "$before" = "$soversion" ] && [ "$unreleased" != unreleased ] && sort "$list" | comm -23 - <(sort "$work/now") | grep .; then
    echo "^ what programs may rely on: raise SOVERSION in CMakeLists.txt, or say 'unreleased'"
    exit 1
  fi
  cp "$work/now" "$list"
  exit
fi
compared='.'
[ "$(uname -m)" = x86_64 ] || compared='^\(soversion\|function\|value\) '
if ! diff <(grep "$compared" "$list") <(grep "$compared" "$work/now"); then
  echo "< $list, > the headers; where that is meant: bash tests/abi.sh $cc update"
  exit 1
fi
