# replay_faults.sh HALFLIGHT: a replay that cannot go as planned. Of a session with a dropped, a clipped
# and a corrupted frame each is named and the others are kept; an interrupted run says how to go on,
# and what goes on ends as if nothing had happened; a full disk is one line, and what was there stays.
set -eu
halflight=$1
session=$PWD/fixtures/dome-faults
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
trap 'exit 1' INT TERM
cd "$work"

# fails STATUS TEXT COMMAND...: that exit status, and one line on stderr with that text
fails() {
  local status=0 want=$1 text=$2
  shift 2
  "$@" >out.txt 2>err.txt || status=$?
  if [ "$status" != "$want" ] || [ "$(wc -l <err.txt)" != 1 ] || ! grep -qF -- "$text" err.txt; then
    echo "$*: exit $status, not $want, or not one line with '$text':" && cat err.txt
    exit 1
  fi
}

# says FILE REASON: of that frame
says() {
  awk -v file="\"$1\"" 'index($0, "\"file\": " file) { here = 1 } here && /"reasons"/ { on = 1 } on { print }
    here && /"exposure_us"/ { exit }' whole/lights.json >reasons.txt
  grep -qF -- "$2" reasons.txt || { echo "$1 does not say '$2':" && cat reasons.txt && exit 1; }
}

fails 3 "2 of 6 frames gave no light: 06.png, 15.png; lights: 1 of 6 frames are not to be trusted: 11.png" \
  "$halflight" replay "$session" --jobs 2 --out whole
grep -q "4 of 6 frames, 3 to be trusted" out.txt
says 06.png "06.png: cannot open"
says 15.png "15.png: its SHA-256 begins"
says 11.png "clipped"
test "$(grep -c '"found": true' whole/lights.json)" = 4
test "$(tail -n +2 whole/lights.lp | wc -l)" = 4

# interrupted once a frame is done; a run that was faster than the signal is tried again
for try in 1 2 3 4 5; do
  rm -rf cut
  status=0
  "$halflight" replay "$session" --jobs 1 --out cut >out.txt 2>err.txt &
  run=$!
  while kill -0 $run 2>/dev/null && ! ls cut/frames/*.json >/dev/null 2>&1; do sleep 0.01; done
  kill -INT $run 2>/dev/null || true
  wait $run || status=$?
  [ "$status" = 3 ] || break
done
if [ "$status" != 3 ]; then
  test "$status" = 1
  test "$(cat err.txt)" = "halflight: replay: interrupted; finished frames are in cut/frames: the same command goes on from there"
  test ! -e cut/lights.json
fi
fails 3 "2 of 6 frames gave no light" "$halflight" replay "$session" --jobs 2 --out cut
grep -q "reused" out.txt
diff -r whole cut

# a disk that is full after 4 kB: files end there
cp -r whole full
rm -r full/frames
cp -r full before
fails 1 "cannot write: File too large" \
  bash -c 'trap "" XFSZ; ulimit -f 4; exec "$@"' - "$halflight" replay "$session" --jobs 1 --out full
rmdir full/frames
diff -r full before
