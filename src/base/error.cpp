#include "voropack/error.h"

#include "voropack/observer.h"

namespace voropack {

namespace {

std::string join(const std::vector<Fault>& faults) {
  std::string text;
  for (const Fault& fault : faults) {
    if (!text.empty()) text += '\n';
    text += fault.text();
  }
  return text;
}

}  // namespace

std::string Fault::text() const {
  std::string text;
  if (!file.empty()) {
    text += file;
    if (line) text += ':' + std::to_string(*line);
    if (line && column) text += ':' + std::to_string(*column);
    text += ": ";
  }
  text += message;
  if (!id.empty()) text += "  [" + id + ']';
  if (!fix.empty()) text += "\n  Fix: " + fix;
  return text;
}

Error::Error(std::vector<Fault> faults) : std::runtime_error(join(faults)), faults_(std::move(faults)) {}

Cancelled::Cancelled() : Error(Fault{.id = "cancelled", .message = "stopped on request"}) {}

Observer& silent_observer() {
  // Stateless: every member function of the base class ignores its arguments, so sharing one is safe.
  static Observer observer;
  return observer;
}

}  // namespace voropack
