# The two commands of the README, then what else the package does with the programs of its wheel.
fail() { echo "failed: $*" >&2; exit 1; }
TIMEFORMAT="%1R s (%1U s + %1S s of the processor)"
export PIP_BREAK_SYSTEM_PACKAGES=1 PIP_NO_INDEX=1 PIP_ROOT_USER_ACTION=ignore

cd /packages
while read -r command; do
  echo "$ $command"
  time said="$(eval "$command")"
  echo "$said"
done < /roots/readme.sh
[[ "$said" == "[5.]" ]] || fail "the README promises [5.]"
pip check
pip list 2> /dev/null | grep -iE '^(grpcio|protobuf|numpy|sightline) '
python3 --version
python3 /roots/own_server.py
