#!/bin/sh
# Kill a replay at random moments and let it go on: replay_kill.sh HALFLIGHT SESSION [TIMES]
# Each time what is there must be readable, and what the run that is let finish leaves must equal, byte for
# byte, what an uninterrupted one does.
set -u
HALFLIGHT=$1
SESSION=$2
TIMES=${3:-50}
WORK=$(mktemp -d)
trap 'rm -rf "$WORK"' EXIT
"$HALFLIGHT" replay "$SESSION" --jobs 2 --out "$WORK/whole" >/dev/null 2>&1
kills=0 broken=0 k=0
while [ "$k" -lt "$TIMES" ]; do
  k=$((k + 1))
  "$HALFLIGHT" replay "$SESSION" --jobs 2 --out "$WORK/cut" >/dev/null 2>&1 &
  pid=$!
  sleep "$(awk -v s="$k$$" 'BEGIN { srand(s); printf "%.3f", 0.05 + 1.2 * rand() }')"
  kill -9 "$pid" 2>/dev/null && kills=$((kills + 1))
  wait "$pid" 2>/dev/null
  for f in "$WORK"/cut/frames/*.json "$WORK"/cut/lights.json; do
    [ ! -f "$f" ] || python3 -m json.tool "$f" >/dev/null 2>&1 || broken=$((broken + 1))
  done
  # every tenth cut starts from nothing
  if [ $((k % 10)) -eq 0 ]; then
    "$HALFLIGHT" replay "$SESSION" --jobs 2 --out "$WORK/cut" >/dev/null 2>&1
    diff -r "$WORK/whole" "$WORK/cut" >/dev/null && echo "after $k: equal" || echo "after $k: DIFFERENT"
    rm -rf "$WORK/cut"
  fi
done
echo "$kills of $TIMES killed while running, $broken files not readable"
