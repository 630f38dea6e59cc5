// A mesh that every check of the certificate accepts, its domain and its control volumes: the unit square or cube, cut
// at x = 1/2 into regions 1 and 2, meshed with a slightly moved grid. Tests spoil one thing at a time.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "voropack/certificate.h"
#include "voropack/domain.h"
#include "voropack/mesh.h"

namespace voropack::test {

template <int D>
struct CertificateCase {
  Domain<D> domain;
  Mesh<D> mesh;
  ControlVolumes<D> volumes;
};

/// n intervals per edge, even; the spheres fit and leave no room (f = 0.479 / n).
template <int D>
CertificateCase<D> golden_case(int n = 4);

/// The same from other points of the cube, which must include the corners of both regions.
template <int D>
CertificateCase<D> case_of_points(const std::vector<Vec<D>>& points);

/// Neighbors from the simplices, whatever they are; control volumes anew.
template <int D>
void refresh(CertificateCase<D>& c);

/// The check of that name. Throws if there is none.
const Certificate::Check& check_named(const Certificate& certificate, std::string_view name);

/// All checks with their verdicts, for messages.
std::string summary(const Certificate& certificate);

/// A simplex without a vertex on the boundary or the interface.
template <int D>
SimplexId interior_simplex(const Mesh<D>& mesh);

/// A vertex inside a region.
template <int D>
VertexId interior_vertex(const Mesh<D>& mesh);

}  // namespace voropack::test
