# merl_reference.sh HALFLIGHT: merl_reference.py, where there is a python3 with numpy.
set -eu
for python in python3 /usr/bin/python3; do
  if "$python" -c 'import numpy' 2>/dev/null; then
    export PYTHONDONTWRITEBYTECODE=1
    exec "$python" tests/merl_reference.py "$1"
  fi
done
echo "no python3 with numpy (Debian: python3-numpy): skipped"
exit 77
