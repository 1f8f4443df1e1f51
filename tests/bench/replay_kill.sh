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
kills=0 broken=0 different=0 k=0
while [ "$k" -lt "$TIMES" ]; do
  k=$((k + 1))
  # every tenth cut starts from nothing, the others from what the cut before was
  [ $((k % 10)) -ne 1 ] || rm -rf "$WORK/cut"
  "$HALFLIGHT" replay "$SESSION" --jobs 2 --out "$WORK/cut" >/dev/null 2>&1 &
  pid=$!
  sleep "$(awk -v s="$k$$" 'BEGIN { srand(s); printf "%.3f", 0.05 + 1.2 * rand() }')"
  kill -9 "$pid" 2>/dev/null && kills=$((kills + 1))
  wait "$pid" 2>/dev/null
  there=0
  for f in "$WORK"/cut/frames/*.json "$WORK"/cut/lights.json; do
    [ -f "$f" ] || continue
    there=$((there + 1))
    python3 -m json.tool "$f" >/dev/null 2>&1 || broken=$((broken + 1))
  done
  # what is there is continued in a copy, so that the next kill finds it as this one left it
  rm -rf "$WORK/rest"
  if [ -d "$WORK/cut" ]; then cp -r "$WORK/cut" "$WORK/rest"; fi
  "$HALFLIGHT" replay "$SESSION" --jobs 2 --out "$WORK/rest" >/dev/null 2>&1
  if diff -r "$WORK/whole" "$WORK/rest" >/dev/null; then
    echo "kill $k: $there files there, continued: equal"
  else
    echo "kill $k: $there files there, continued: DIFFERENT" && different=$((different + 1))
  fi
done
echo "$kills of $TIMES killed while running, $broken files not readable, $different not equal when continued"
