#include "cli/driver_script.h"

#include <filesystem>

namespace atl::test {

std::string write_driver(const ScratchDirectory& scratch, const std::string& engine) {
  const std::string head = "#!/bin/sh\nengine=" + engine + "\n";
  const std::string body = R"(
if [ "$1" = --describe ]; then
  cat <<END
{"engine": "$engine", "version": "7.1", "precision": "single", "settings": [
  {"label": "default", "options": [], "large": true},
  {"label": "better", "options": ["--better"], "large": false},
  {"label": "toppling", "options": ["--fell"], "large": false},
  {"label": "breaking", "options": ["--broken"], "large": false},
  {"label": "endless", "options": ["--slow"], "large": false},
  {"label": "odd</script><b>", "options": ["--odd"], "large": false}]}
END
  exit
fi
error=0.001 seconds=2 fell=false
[ $engine != Swift ] || error=0 seconds=1e-9
case "$*" in
  stack:height=3*) echo "$engine: has no stacks of three" >&2; exit 3 ;;
  *--broken*) echo "$engine: body 1 is not finite" >&2; exit 4 ;;
  *--slow*) exec sleep 1000 ;;
  *--odd*) echo nonsense; exit ;;
  *--better*) error=0 seconds=4 ;;
  *--fell*) fell=true ;;
esac
case "$*" in
  chain*--better*--errors*) echo "{\"errors\": {\"joint_gap_run_max\": 0.9}, \"fell\": false}" ;;
  chain*--errors*) echo "{\"errors\": {\"joint_gap_run_max\": 2}, \"fell\": false}" ;;
  *--errors*) echo "{\"errors\": {\"penetration_mean\": $error, \"sink_max\": 1e-3}, \"fell\": $fell}" ;;
  *--time*) echo "{\"cpu_s_per_simulated_s\": $seconds, \"ms_per_step\": {\"mean\": 33.5}, \"runs\": 1}" ;;
esac
)";
  const std::string path = scratch.write(engine + "-driver", head + body);
  std::filesystem::permissions(path, std::filesystem::perms::owner_all);
  return path;
}

}  // namespace atl::test
