#!/bin/sh
# mrcal.sh HALFLIGHT: calibrations side by side with mrcal and OpenCV, on the same corners: simulated
# ones of known truth, and the chessboard photos where ../shared/data has them. Needs Debian's mrcal
# and python3-opencv; exit status 77 (skipped) without them.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
python=/usr/bin/python3
"$python" -c 'import cv2, mrcal, numpy' 2>/dev/null || { echo "no mrcal, OpenCV or numpy for $python"; exit 77; }
exec "$python" "$here/mrcal_table.py" "$1" "$here/../../../shared/data/chessboards"
