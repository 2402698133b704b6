# The wheel with programs, without any package that it asks for: both commands work, of themselves and on a data directory, and pip
# removes all that it has installed.
fail() { echo "failed: $*" >&2; exit 1; }
TIMEFORMAT="%1R s (%1U s + %1S s of the processor)"
# pip may change Debian's own Python here, and asks no index.
export PIP_BREAK_SYSTEM_PACKAGES=1 PIP_NO_INDEX=1 PIP_ROOT_USER_ACTION=ignore PYTHONDONTWRITEBYTECODE=1
export SIGHTLINE_ENDPOINT=unix:/tmp/sightline.socket

find / -xdev -not -type d -not -path '/tmp/*' -not -path '/var/*' | sort > /tmp/before
time pip install --quiet --no-compile --no-deps /packages/sightline-*.whl
du -sh "$(python3 -c 'import sightline_programs as found; print(found.__path__[0])')"

# No library but the C library's is taken from the system.
for program in sightline sightlined; do
  "$program" --version
  path="$(python3 -c "import sightline_programs as found; print(found.__path__[0])")/bin/$program"
  outside="$(ldd "$path" | grep ' => ' | grep -v "=> ${path%/*}/../lib/" | grep -vE '^\s*(libc|libm|libresolv)\.so' || true)"
  [[ -z "$outside" ]] || fail "$program loads $outside"
done

sightlined --listen "$SIGHTLINE_ENDPOINT" --data-dir /tmp/data --port-file /tmp/port 2> /tmp/log &
server=$!
for _ in {1..600}; do
  if [[ -s /tmp/port ]] || ! kill -0 "$server" 2> /dev/null; then break; fi
  sleep 0.1
done
[[ -s /tmp/port ]] || fail "the server did not start: $(cat /tmp/log)"

# hit SCENE RAY: the nearest.
hit() {
  local said
  said="$(echo "$2" | sightline cast "$1" | sed -n 2p)"
  [[ "$said" =~ ^[0-9] ]] || fail "no hit in $1: $said"
  echo "$1: $said"
}
time sightline scene import engine /packages/2CylinderEngine.glb
hit engine "0 500 0 0 -1 0"
time sightline scene import house /packages/AC14-FZK-Haus.ifc
hit house "5 5 100 0 0 -1"
# What the sandboxed reader cannot read is refused, not fatal.
echo "not a scene" > /tmp/bad.glb
if sightline scene import bad /tmp/bad.glb 2> /tmp/said; then fail "a damaged file was imported"; fi
cat /tmp/said

kill -TERM "$server"
wait "$server" || fail "the server did not end well: $(tail -n 3 /tmp/log)"
pip uninstall --quiet --yes sightline
find / -xdev -not -type d -not -path '/tmp/*' -not -path '/var/*' | sort > /tmp/after
diff /tmp/before /tmp/after || fail "pip has left these"
