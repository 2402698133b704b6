// sightline, the client command.
#include "client/cli/program.h"

int main(int argc, char** argv) { return sightline::client::cli::run_program(argc, argv); }
