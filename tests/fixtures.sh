#!/bin/sh
# fixtures.sh HALFLIGHT [all|pfm [TABLE]]: the light of every recorded frame, with the ball's true pose and with
# the pose found in the frame, against the truth. Prints a table and fails beyond the limits.
# With `pfm`, only the frames that need no image library. The table is left in the file TABLE, too.
set -u
halflight=$1
kinds=${2:-all}
table=${3:-/dev/null}
here=$(cd "$(dirname "$0")" && pwd)
fixtures=$here/../fixtures
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
trap 'exit 1' INT TERM
LC_ALL=C
export LC_ALL

# numbers FILE MEMBER: the first array or number of that name, its numbers on one line
numbers()
{
  awk -v name="\"$2\":" '
    { text = text " " $0 }
    END {
      at = index(text, name)
      if (!at) exit
      text = substr(text, at + length(name))
      sub(/^ */, "", text)
      sub(text ~ /^\[/ ? "].*" : "[,}].*", "", text)
      gsub(/[][,]/, " ", text)
      print text
    }' "$1"
}

# estimate FRAME CAMERA OPTION VALUE: error [deg], half axes of the ellipse, status
estimate()
{
  frame=$1 camera=$2
  shift 2
  status=0
  "$halflight" estimate "$frame" --camera "$camera" "$@" --json \
    >"$work/light.json" 2>"$work/stderr" || status=$?
  case $status in
  0) trusted=ok ;;
  3) trusted=untrusted ;;
  *) trusted=failed ;;
  esac
  printf '%s %s\n' "$truth" "$(numbers "$work/light.json" direction)" | awk -v trusted=$trusted '
    NF != 6 { print 180, trusted; exit }
    {
      x = $2 * $6 - $3 * $5; y = $3 * $4 - $1 * $6; z = $1 * $5 - $2 * $4
      error = atan2(sqrt(x * x + y * y + z * z), $1 * $4 + $2 * $5 + $3 * $6) * 57.29577951308232
      printf "%.4f %s\n", error, trusted
    }'
}

for folder in "$fixtures"/*/; do
  [ -f "$folder/sphere.json" ] || continue # a calibration session has none
  frame=$(echo "$folder"frame.*)
  if [ "$kinds" = pfm ] && [ "${frame##*.}" != pfm ]; then
    continue
  fi
  truth=$(numbers "$folder/truth.json" light)
  radius=$(numbers "$folder/sphere.json" radius_m)
  known=$(estimate "$frame" "$folder/camera.json" --sphere "$folder/sphere.json")
  # shellcheck disable=SC2086 # one word, with blanks around it
  own=$(estimate "$frame" "$folder/camera.json" --radius-m $radius)
  echo "$(basename "$folder") $known $own"
done >"$work/table"

awk '
  # sorts a in passing
  function median(a, n,    i, j, t) {
    for (i = 2; i <= n; i++)
      for (j = i; j > 1 && a[j - 1] > a[j]; j--) { t = a[j]; a[j] = a[j - 1]; a[j - 1] = t }
    return n % 2 ? a[(n + 1) / 2] : (a[n / 2] + a[n / 2 + 1]) / 2
  }
  function limit(what, figure, most,    good) {
    good = figure <= most
    printf "%-30s %8.4f <= %g  %s\n", what, figure, most, good ? "ok" : "FAILED"
    bad += !good
  }
  BEGIN { print "light error [deg]     pose known            pose found in the frame" }
  NF != 5 { print; bad++; next }
  {
    printf "%-20s %8.4f  %-10s  %8.4f  %s\n", $1, $2, $3, $4, $5
    known[++n] = $2 + 0; own[n] = $4 + 0
  }
  END {
    if (!n) { print "no frames"; exit 1 }
    middle = median(known, n)
    # the limits of the middle are for the whole set: a single frame has none
    if (n > 1) limit("pose known: median", middle, 0.03)
    limit("pose known: largest", known[n], 0.3)
    middle = median(own, n)
    if (n > 1) limit("pose found: median", middle, 0.12)
    else limit("pose found: largest", own[n], 0.3)
    exit bad > 0
  }' "$work/table" >"$work/report"
status=$?
cat "$work/report"
cat "$work/report" >"$table"
exit "$status"
