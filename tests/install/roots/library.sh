# Builds the consumer with the installed library, found by CMake and by pkg-config, and casts a ray from each.
fail() { echo "failed: $*" >&2; exit 1; }
TIMEFORMAT="%1R s (%1U s + %1S s of the processor)"
cd /roots/consumer || exit

echo "by CMake:"
time (cmake -S . -B /tmp/built > /tmp/log && cmake --build /tmp/built >> /tmp/log)
echo "by pkg-config:"
read -r -a flags <<< "$(pkg-config --cflags --libs sightline)"
time c++ -std=c++20 cast_one_ray.cpp "${flags[@]}" -o /tmp/by_pkg_config
for program in /tmp/built/consumer /tmp/by_pkg_config; do
  said="$("$program" "$SIGHTLINE_ENDPOINT")"
  echo "$program: $said, $(stat -c %s "$program") bytes"
  [[ "$said" == "1 hit, t 1.5, primitive 1" ]] || fail "another answer was expected"
done
