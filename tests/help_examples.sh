# help_examples.sh HALFLIGHT MAKERS OPENCV [show]: what `VERB --help` gives as an example is run, and
# prints what is said there. Lines that begin with `$` are commands, those that follow what they
# print: words must be equal and numbers near; `...` stands for the rest, of the
# line or of all. MAKERS is the folder of
# make_ball and make_corners; OPENCV is ON where the build calibrates. `show` prints all of it.
set -eu
halflight=$1 makers=$2 opencv=$3 show=${4:-}
cli=$PWD/tests/cli
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/in" "$work/bin"
ln -s "$halflight" "$work/bin/halflight"
PATH=$work/bin:$PATH
export PATH LC_ALL=C
cd "$work/in"
# shellcheck disable=SC1091
. "$cli/drift_files.sh"
# shellcheck disable=SC1091
. "$cli/position_files.sh"

# what the examples read
"$makers/make_ball"
"$makers/make_corners"
awk -v n=900 -f "$cli/make_samples.awk" > samples.csv
drift_camera reference.json 700 640 good
drift_camera today.json 703.5 640 good
drift_corners fixed.vnl 700 -0.12 1
position_pair left -0.3 0.3
position_pair right 0.3 -0.3
mkdir recorded
cp frame.pfm camera.json recorded/
echo '{"format":"halflight-session","version":1,"device":"bench","camera":"camera.json","radius_m":0.02,
 "frames":[{"file":"frame.pfm","label":"left","timestamp_ns":1000000,"exposure_us":8000,"gain":1}]}' > recorded/session.json
mkdir ball
cp frame.pfm camera.json sphere.json ball/
echo '{"light":[0.318090,-0.423915,-0.848006]}' > ball/truth.json

# near GOT WANTED
near() {
  awk -v wanted="$2" '
    function number(w) { return w ~ /^[-+]?[0-9]*[.]?[0-9]+(e[-+]?[0-9]+)?$/ }
    function trim(w) { sub(/[),;:%]+$/, "", w); sub(/^\(/, "", w); return w }
    function abs(x) { return x < 0 ? -x : x }
    BEGIN { while ((getline line < wanted) > 0) want[++m] = line }
    { got[NR] = $0 }
    END {
      for (i = 1; i <= m; i++) {
        if (want[i] ~ /^ *[.][.][.]$/) exit 0
        n = split(want[i], w)
        m_got = split(got[i], g)
        rest = n > 1 && w[n] == "..."
        if (rest) n--
        same = rest ? n < m_got : n == m_got
        for (k = 1; k <= n && same; k++) {
          a = trim(g[k])
          b = trim(w[k])
          if (a != b && !(number(a) && number(b) && abs(a - b) <= 0.05 * abs(b) + 1e-4)) same = 0
        }
        if (!same) { print "it says:   " want[i]; print "it prints: " got[i]; exit 1 }
      }
      if (NR > m) { print "it prints too: " got[m + 1]; exit 1 }
    }' "$1"
}

failed=0 run=0
for verb in $(halflight --help | awk '/^  [a-z]/ { print $1 }'); do
  halflight "$verb" --help | awk '/^example:$/ { inside = 1; next } inside && /^[^ ]/ { exit } inside' |
    sed 's/^  //; /^$/d' > "$work/example"
  if ! grep -q '^\$ halflight '"$verb" "$work/example"; then
    echo "$verb: its help has no example"
    failed=1
    continue
  fi
  case $verb in
  calibrate) [ "$opencv" = ON ] || continue ;;
  esac
  rm -rf "$work"/step.*
  awk -v to="$work/step." '
    /^\$ / { file = sprintf("%s%02d", to, ++n); print substr($0, 3) > (file ".sh"); printf "" > (file ".out"); more = /\\$/; next }
    more { print > (file ".sh"); more = /\\$/; next }
    { print > (file ".out") }' "$work/example"
  for step in "$work"/step.*.sh; do
    status=0
    sh "$step" > "$work/got" 2>&1 || status=$?
    run=$((run + 1))
    if [ "$show" = show ]; then
      sed 's/^/$ /' "$step"
      cat "$work/got"
    fi
    case $status in
    0 | 3) ;;
    *) echo "$verb: exit status $status of: $(cat "$step")"; cat "$work/got"; failed=1 ;;
    esac
    near "$work/got" "${step%.sh}.out" || { echo "$verb: ^ of: $(cat "$step")"; failed=1; }
  done
done
echo "$run commands run"
exit $failed
