#!/bin/sh
# calibration.sh HALFLIGHT: the recorded calibration sessions. Each is calibrated and held against its
# truth; then each is compared with the first, as a whole and by its fixed board alone, and what moved
# has to be called by its name. Prints a table and fails beyond the limits.
set -u
halflight=$1
here=$(cd "$(dirname "$0")" && pwd)
fixtures=$here/../fixtures
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
trap 'exit 1' INT TERM
LC_ALL=C
export LC_ALL
bad=0

complain()
{
  echo "MISS $*"
  bad=1
}

# number FILE MEMBER: the first number of that name
number()
{
  awk -v name="\"$2\":" '$1 == name { gsub(/,/, ""); print $2; exit }' "$1"
}

# deviations FILE: of fx, fy, cx, cy
deviations()
{
  awk '/"covariance":/ { inside = 1; next }
       inside && n < 4 { gsub(/[][,]/, " "); n++; print sqrt($n) }' "$1"
}

# within WHAT ERROR LIMIT
within()
{
  if awk -v e="$2" -v l="$3" 'BEGIN { exit !(e <= l && -e <= l) }'; then
    printf 'ok   %s: %.4g within %.4g\n' "$1" "$2" "$3"
  else
    complain "$1: $2, beyond $3"
  fi
}

# parts DRIFT.json: "same", or the parts that moved
parts()
{
  awk '/"verdict":/ { if (/same/) { print "same"; exit } }
       /"part":/ { part = $0; sub(/.*"part": "/, "", part); sub(/".*/, "", part) }
       /"moved": true/ { moved = moved (moved ? ", " : "") part }
       END { if (moved) print moved }' "$1"
}

# compared WHAT EXPECTED OPTION...: drift against the first session
compared()
{
  what=$1 expected=$2
  shift 2
  status=0
  "$halflight" drift "$work/calibration-a.json" "$@" --json >"$work/drift.json" 2>"$work/stderr" ||
    status=$?
  got=$(parts "$work/drift.json")
  due=3
  [ "$expected" = same ] && due=0
  if [ "$got" = "$expected" ] && [ $status = $due ]; then
    echo "ok   $what: $got"
  else
    complain "$what: '$got' with exit status $status instead of '$expected' with $due"
    cat "$work/stderr"
  fi
}

for name in calibration-a calibration-b calibration-c calibration-d; do
  folder=$fixtures/$name
  camera=$work/$name.json
  target=$(awk '$1 == "\"target\":" { gsub(/[",]/, ""); print $2; exit }' "$folder/truth.json")
  if ! "$halflight" calibrate "$folder"/[0-9]*.jpg --target "$target" --out "$camera" \
    >"$work/stdout" 2>"$work/stderr"; then
    complain "$name: not calibrated: $(cat "$work/stderr")"
    continue
  fi
  k=0
  for member in fx fy cx cy; do
    k=$((k + 1))
    truth=$(number "$folder/truth.json" $member)
    error=$(awk -v a="$(number "$camera" $member)" -v b="$truth" 'BEGIN { print a - b }')
    deviation=$(deviations "$camera" | sed -n ${k}p)
    # floors: focal length 0.1 %, centre 0.7 px; and what the calibration itself states
    case $member in
    f?) within "$name $member [px]" "$error" "$(awk -v t="$truth" 'BEGIN { print 0.001 * t }')" ;;
    *) within "$name $member [px]" "$error" 0.7 ;;
    esac
    within "$name $member [its own deviations]" \
      "$(awk -v e="$error" -v d="$deviation" 'BEGIN { print (d > 0 ? e / d : 1e9) }')" 3
  done
done

# b is the camera of a; c has a focal length 0.4 % longer on a mount that moved, d the mount alone
mount="rotation, translation"
compared "calibration-b against a" same "$work/calibration-b.json"
compared "calibration-c against a" "focal length, $mount" "$work/calibration-c.json"
compared "calibration-d against a" "$mount" "$work/calibration-d.json"

if "$halflight" drift "$work/calibration-a.json" --board "$fixtures/calibration-a/fixed.png" \
  --save-board-pose "$work/pose.json" >"$work/stdout" 2>"$work/stderr"; then
  compared "fixed board of b" same --board "$fixtures/calibration-b/fixed.png" --board-pose "$work/pose.json"
  compared "fixed board of c" "focal length, $mount" \
    --board "$fixtures/calibration-c/fixed.png" --board-pose "$work/pose.json"
  compared "fixed board of d" "$mount" --board "$fixtures/calibration-d/fixed.png" --board-pose "$work/pose.json"
else
  complain "no pose of the fixed board: $(cat "$work/stderr")"
fi
exit $bad
