# exports.sh LIBRARY: a shared library shows hl_* functions and nothing else, and all the headers name.
set -eu
shown=$(nm -D --defined-only "$1" | awk '{print $3}' | sort)
test -n "$shown"
if echo "$shown" | grep -v '^hl_'; then
  echo "^ exported, but none of hl_*"
  exit 1
fi
promised=$(cat include/halflight/*.h | tr '\n' ' ' | grep -oE 'HL_API [^;(]*\bhl_[a-z0-9_]+\(' |
  grep -oE 'hl_[a-z0-9_]+\($' | tr -d '(' | sort)
echo "$(echo "$promised" | wc -l) functions promised, $(echo "$shown" | wc -l) shown"
if ! diff <(echo "$promised") <(echo "$shown"); then
  echo "< promised by the headers, > shown by the library"
  exit 1
fi
