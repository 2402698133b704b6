# Installs the wheel into an environment of its own, without an index, and casts from there.
TIMEFORMAT="%1R s (%1U s + %1S s of the processor)"
python3 -m venv --system-site-packages /tmp/venv
time /tmp/venv/bin/pip install --quiet --no-index /packages/sightline-*.whl
/tmp/venv/bin/pip check
/tmp/venv/bin/python /roots/cast.py
