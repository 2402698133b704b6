// Writes the manual pages of both programs: sightline_manual DIRECTORY makes DIRECTORY/man1 and man8.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <string>

#include "client/cli/program.h"
#include "client/cli/reference/manual.h"
#include "client/cli/session.h"
#include "server/describe.h"

namespace {

namespace cli = sightline::client::cli;

void write_pages(const CLI::App& program, int section, const std::filesystem::path& directory) {
  const std::filesystem::path folder = directory / ("man" + std::to_string(section));
  std::filesystem::create_directories(folder);
  const std::string source = "sightline " SIGHTLINE_VERSION;
  for (const auto& page : cli::reference::manual_of(program, section, source)) {
    std::ofstream file;
    file.exceptions(std::ios::failbit | std::ios::badbit);
    file.open(folder / page.file);
    file << page.text << std::flush;
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return std::fputs("sightline_manual DIRECTORY\n", stderr), 2;
  try {
    const std::filesystem::path directory = argv[1];
    cli::Session session;
    write_pages(*cli::make_program(session), 1, directory);
    const auto write = [&directory](const CLI::App& app) { write_pages(app, 8, directory); };
    sightline::server::describe_flags(write);
    sightline::server::describe_doctor_flags(write);
  } catch (const std::exception& error) {
    return std::fprintf(stderr, "sightline_manual: %s\n", error.what()), 1;
  }
}
