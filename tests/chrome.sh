#!/bin/sh
# Real photos of two chrome spheres under 12 lights, where they are there: chrome.sh HALFLIGHT [DATA]
# The camera is not known: a long lens is assumed (20 widths), as those who stored the directions did. Balls
# are where circle_data.txt has them (x, y up, radius, from 1).
set -eu
HALFLIGHT=$1
DATA=${2:-../shared/data/chrome}
if [ ! -d "$DATA/LightProbe-1" ]; then
  echo "skipped: no photos at $DATA"
  exit 77
fi
WORK=$(mktemp -d)
trap 'rm -rf "$WORK"' EXIT

session()
{ # PROBE WIDTH HEIGHT
  mkdir "$WORK/$1"
  cp "$DATA/$1"/Image_*.JPG "$WORK/$1"
  tr '\n' ' ' <"$DATA/$1/circle_data.txt" | awk -v w="$2" -v h="$3" -v dir="$WORK/$1" '{
    f = 20 * w; r = 0.03; d = r / sin(atan2($3, f)); x = ($1 - 1 - (w - 1) / 2) / f; y = (h - $2 - (h - 1) / 2) / f
    n = sqrt(x * x + y * y + 1)
    printf "{\"format\":\"halflight-camera\",\"version\":1,\"model\":\"pinhole\",\"width\":%d,\"height\":%d," \
      "\"fx\":%g,\"fy\":%g,\"cx\":%g,\"cy\":%g,\"distortion\":[0,0,0,0,0]}\n", w, h, f, f, (w - 1) / 2, (h - 1) / 2 > (dir "/camera.json")
    printf "{\"format\":\"halflight-sphere\",\"version\":1,\"radius_m\":%g,\"center_m\":[%.9g,%.9g,%.9g]}\n", r, d * x / n, d * y / n, d / n > (dir "/sphere.json")
    printf "{\"format\":\"halflight-session\",\"version\":1,\"camera\":\"camera.json\",\"sphere\":\"sphere.json\",\"frames\":[" > (dir "/session.json")
    for (i = 1; i <= 12; i++)
      printf "%s{\"file\":\"Image_%02d.JPG\",\"label\":\"%d\"}", (i > 1 ? "," : ""), i, i > (dir "/session.json")
    print "]}" > (dir "/session.json")
  }'
}

session LightProbe-1 1100 1000
session LightProbe-2 950 950
for probe in LightProbe-1 LightProbe-2; do
  "$HALFLIGHT" replay "$WORK/$probe" --out "$WORK/$probe-out" >"$WORK/$probe.txt" 2>&1 || [ $? -eq 3 ]
  [ -f "$WORK/$probe-out/lights.lp" ] || { cat "$WORK/$probe.txt"; exit 1; }
  awk -v probe="$probe" 'NR == FNR { for (i = 1; i <= 12; i++) t[FNR, i] = $i; next }
    FNR > 1 { n = $1; gsub(/[^0-9]/, "", n); k = n + 0
      c = $2 * t[1, k] + $3 * t[2, k] + $4 * t[3, k]; s = sqrt((1 - c * c > 0) ? 1 - c * c : 0)
      e[++m] = atan2(s, c) * 57.29578 }
    END { for (i = 1; i <= m; i++) for (j = i + 1; j <= m; j++) if (e[j] < e[i]) { x = e[i]; e[i] = e[j]; e[j] = x }
      middle = (e[int((m + 1) / 2)] + e[int((m + 2) / 2)]) / 2
      printf "%s: %d of 12 lights, from the stored directions median %.2f deg, most %.2f deg (a long lens is assumed)\n", \
        probe, m, middle, e[m]
      exit !(m >= 10 && middle <= 1.0) }' "$DATA/light_directions.txt" "$WORK/$probe-out/lights.lp"
done
