# capture_kill.sh HALFLIGHT [KILLS [SEED]]: a capture is killed (SIGKILL) at random moments. After each kill the
# session reads, and every frame it lists is there with the hash it states; when it is complete, at last,
# it equals the session of an uninterrupted capture byte for byte. Prints a line a kill.
set -eu
halflight=$1
kills=${2:-5}
RANDOM=${3:-1}
frames=24
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
trap 'exit 1' INT TERM
cd "$work"

mkdir rec
list=
for ((k = 0; k < frames; k++)); do
  { printf 'Pf\n64 48\n-1.0\n' && yes "$k" | head -c $((4 * 64 * 48)); } >"rec/$k.pfm"
  list="$list${list:+,}{\"file\":\"$k.pfm\",\"timestamp_ns\":$((k + 1))000000,\"exposure_us\":5000,\"gain\":1}"
done
echo "{\"format\":\"halflight-session\",\"version\":1,\"frames\":[$list]}" >rec/session.json

capture() {
  "$halflight" capture --recorded rec --full-speed --frames $frames --exposure-us 5000 --gain 1 --out "$1" >log 2>&1
}
# read FOLDER: prints how many frames are listed; fails where one is not as the list says
read_session() {
  "$halflight" capture --list --recorded "$1" >/dev/null || { echo "unreadable after a kill" >&2; return 1; }
  awk -F'"' '$2 == "file" { file = $4 } $2 == "sha256" { print $4 "  " file }' "$1/session.json" >sums
  (cd "$1" && [ ! -s ../sums ] || sha256sum --quiet -c ../sums) || return 1
  wc -l <sums
}

before=$(date +%s%N)
capture whole
length=$((($(date +%s%N) - before) / 1000000 + 1))
test "$(read_session whole)" = $frames
finished=0
for ((k = 1; k <= kills; k++)); do
  "$halflight" capture --recorded rec --full-speed --frames $frames --exposure-us 5000 --gain 1 --out out >log 2>&1 &
  victim=$!
  after=$((RANDOM % length))
  sleep "$(printf '%d.%03d' $((after / 1000)) $((after % 1000)))"
  kill -9 $victim 2>/dev/null || true
  wait $victim 2>/dev/null || true
  held=none
  if [ -e out/session.json ]; then
    held=$(read_session out)
  fi
  echo "kill $k after $after ms: $held frames"
  if [ "$held" = $frames ]; then
    diff -r whole out
    rm -r out
    finished=$((finished + 1))
  fi
done
capture out
diff -r whole out
echo "$kills kills; $((finished + 1)) sessions completed, each equal to the uninterrupted one"
