// Tables for standard output: counts, quality, certificate.
#pragma once

#include <string>

#include "voropack/certificate.h"
#include "voropack/quality.h"

namespace voropack::app {

std::string count_table(const QualityReport& quality);
std::string quality_table(const QualityReport& quality);
/// Small histograms of the spreads, one line per bin.
std::string histograms(const QualityReport& quality);
std::string certificate_table(const Certificate& certificate);

/// Prints `text` to standard output. Throws InputError cli.stdout if it takes no more, but not if its reader is gone.
void print_to_stdout(const std::string& text);

}  // namespace voropack::app
