#!/bin/sh
# stability.sh COMMAND: the statuses of the stability suite are those of src/doc/stability.md, for every
# case that `--fast` runs. Digits may differ between compilers; statuses may not.
set -eu
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
trap 'exit 1' INT TERM
code=0
"$1" bench --stability --fast >"$work/now.md" 2>"$work/err" || code=$?
if [ $code -ne 0 ]; then
  cat "$work/err"
  exit 1
fi
rows() { sed -n 's/^| \([^|]*|[^|]*|[^|]*|[^|]*\)|.*/\1/p' "$1" | grep -v -e '---' -e Varied; }
rows "$work/now.md" >"$work/now"
rows src/doc/stability.md >"$work/stated"
[ "$(wc -l <"$work/now")" -ge 60 ] || { echo "too few cases"; exit 1; }
if grep -v -x -F -f "$work/stated" "$work/now"; then
  echo "above: not as src/doc/stability.md has it; 'halflight bench --stability --fast' prints it anew"
  exit 1
fi
