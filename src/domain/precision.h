// How finely the coordinates of an input are given.
#pragma once

#include "voropack/domain.h"

namespace voropack::domain_impl {

/// The distance between neighboring numbers of the input's format at its largest coordinate: of single precision if
/// all coordinates are such numbers, of six or so many decimal digits if none has more than nine. 0 if neither holds.
double coordinate_unit(const DomainInput<3>& input);

}  // namespace voropack::domain_impl
