// One program for each reader: VOROPACK_FUZZ_TARGET is its index in kTargets.
#include <cstdint>

#include "fuzz/targets.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  if (!voropack::fuzz::accepts_or_rejects(voropack::fuzz::kTargets[VOROPACK_FUZZ_TARGET], bytes)) std::abort();
  return 0;
}
