// The command line `sightlined doctor`.
#include "server/doctor_command.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <string>

#include "server/config.h"
#include "server/describe.h"
#include "server/store/doctor.h"

namespace sightline::server {
namespace {

struct DoctorFlags {
  std::filesystem::path directory;
  store::Treatment treatment;
};

void add_doctor_flags(CLI::App& app, DoctorFlags& flags) {
  app.description("Examines a data directory that no server uses");
  app.name("sightlined doctor");
  app.add_option("DIR", flags.directory, "The directory that --data-dir names")->required();
  app.add_flag("--repair", flags.treatment.repair,
               "Move damaged meshes aside, so that they can be uploaded again, and remove files "
               "that the database does not name");
  app.add_flag("--accept-loss", flags.treatment.accept_loss,
               "Go on without updates that were acknowledged and are lost: their scenes get new "
               "tokens");
}

}  // namespace

void describe_doctor_flags(const std::function<void(const CLI::App&)>& read) {
  DoctorFlags flags;
  CLI::App app;
  add_doctor_flags(app, flags);
  read(app);
}

int run_doctor(int argc, const char* const* argv) {
  DoctorFlags flags;
  CLI::App app;
  add_doctor_flags(app, flags);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kUsageExit;
  }
  const auto found = store::examine(store::local_files(), flags.directory, flags.treatment);
  if (!found) {
    std::fprintf(stderr, "sightlined: %s\n", found.error().message.c_str());
    return 1;
  }
  for (const std::string& finding : found->findings) std::printf("found: %s\n", finding.c_str());
  for (const std::string& done : found->repairs) std::printf("repaired: %s\n", done.c_str());
  if (found->findings.empty()) std::printf("%s is sound\n", flags.directory.c_str());
  return found->findings.empty() ? 0 : 1;
}

}  // namespace sightline::server
