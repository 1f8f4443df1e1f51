# schema.sh HALFLIGHT MAKERS OPENCV: every JSON document that the command writes is what its schema in
# src/schema says, and a spoilt one is refused. MAKERS is the folder of make_ball and make_corners,
# OPENCV is ON where the build calibrates. Needs python3 with jsonschema.
set -eu
halflight=$1 makers=$2 opencv=$3
top=$PWD
cli=$top/tests/cli
python=
for one in /usr/bin/python3; do
  if "$one" -c 'import jsonschema' 2> /dev/null; then
    python=$one
    break
  fi
done
if [ -z "$python" ]; then
  echo "skipped: no python3 with jsonschema; the package python3-jsonschema is needed"
  exit 77
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
# shellcheck disable=SC1091
. "$cli/drift_files.sh"
# shellcheck disable=SC1091
. "$cli/position_files.sh"

# may_doubt COMMAND...: an answer that is not to be trusted, or has drifted, is a document too
may_doubt() {
  local status=0
  "$@" 2> doubt || status=$?
  case $status in
  0 | 3) ;;
  *) cat doubt; echo "$*: exit status $status"; return 1 ;;
  esac
}

"$makers/make_ball"
mkdir json
"$halflight" info --json > json/info.json
"$halflight" locate frame.pfm --camera camera.json --radius-m 0.02 --out json/sphere.json > /dev/null
"$halflight" locate frame.pfm --camera camera.json --radius-m 0.02 --json > json/sphere-printed.json
"$halflight" estimate frame.pfm --camera camera.json --radius-m 0.02 --out out > /dev/null
cp out/light.json json/light.json
cp out/evidence.json json/evidence.json
"$halflight" estimate frame.pfm --camera camera.json --normals normals.pfm --json > json/light-normals.json
"$halflight" relight out/light.json --light=0,0,-1 --sphere-px 20 --out relit.png --json > json/relit.json
awk -v n=900 -f "$cli/make_samples.awk" > samples.csv
for model in ridge dichromatic additive pursuit torrance-sparrow; do
  light=--light=1,1,1
  [ $model != ridge ] || light=
  # shellcheck disable=SC2086
  may_doubt "$halflight" fit samples.csv --model $model $light --json > json/fit-$model.json
done
mkdir recorded
cp frame.pfm recorded/a.pfm
cp camera.json recorded/
cat > recorded/session.json << 'JSON'
{"format":"halflight-session","version":1,"device":"bench","camera":"camera.json","radius_m":0.02,
 "frames":[{"file":"a.pfm","label":"left","timestamp_ns":1000000,"exposure_us":5000,"gain":1}]}
JSON
"$halflight" capture --recorded recorded --frames 1 --exposure-us 5000 --gain 1 --label left \
  --camera camera.json --radius-m 0.02 --out session > capture.log
cp session/session.json json/session.json
may_doubt "$halflight" replay session --out replayed > replay.log
cp replayed/lights.json json/lights.json
if [ "$opencv" = ON ]; then # its frames are PNG
  may_doubt "$halflight" replay "$top/fixtures/dome-a" --out dome > replay.log
  cp dome/lights.json json/lights-dome.json
fi
cp replayed/frames/00000.json json/light-replayed.json
"$makers/make_ball" fill=black frame=black.pfm
may_doubt "$halflight" estimate black.pfm --camera camera.json --sphere sphere.json --json > json/light-none.json
drift_camera json/camera.json 700 640 good
drift_camera other.json 703.5 640 good
may_doubt "$halflight" drift json/camera.json other.json --json > json/drift.json
mkdir before now
drift_rig before/lights.json 0 1
drift_rig now/lights.json 0.02 1.2
may_doubt "$halflight" drift before now --json > json/drift-sessions.json
position_pair left -0.3 0.3
position_pair right 0.3 -0.3
"$halflight" position left-light.json left.json right-light.json right.json --json > json/position.json
position_pair left -0.3 -0.3
position_pair right 0.3 0.3
may_doubt "$halflight" position left-light.json left.json right-light.json right.json --json > json/position-none.json
mkdir scene
cp frame.pfm camera.json sphere.json scene/
echo '{"light":[0,0,-1]}' > scene/truth.json # only its form counts here
"$halflight" bench scene --json > json/bench.json
if [ "$opencv" = ON ]; then
  "$makers/make_corners"
  may_doubt "$halflight" calibrate --corners corners.vnl --image-size 640x480 --target aprilgrid:6x6:0.03:0.3 \
    --uncertainty-at 10,20 --uncertainty-at 30,40,2.5 --json > json/camera-calibrated.json
  drift_corners fixed.vnl 700 -0.12 1
  "$halflight" drift json/camera.json --board fixed.vnl --target chessboard:9x7:0.03 \
    --save-board-pose json/board-pose.json > /dev/null
else
  drift_pose json/board-pose.json chessboard:9x7:0.03
fi
"$python" "$top/tests/schema.py" "$top/src/schema" --mutate json/*.json before/lights.json recorded/session.json \
  "$top"/fixtures/*/{camera,sphere,session,fixed}.json
