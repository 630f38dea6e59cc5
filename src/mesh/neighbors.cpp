// Adjacency of simplices: faces are put into one bucket for each smallest vertex, and matched inside of each.
#include <fmt/format.h>

#include <atomic>

#include "base/parallel.h"
#include "mesh/faces.h"
#include "mesh/vertex_set_table.h"
#include "voropack/error.h"
#include "voropack/mesh.h"

namespace voropack {

namespace {

/// A face in the bucket of its smallest vertex.
template <int D>
struct FaceRecord {
  std::array<VertexId, D - 1> others;  ///< Its other vertices, ascending.
  SimplexId simplex;
  std::uint8_t corner = 0;  ///< The face is opposite to this corner of the simplex.
  bool odd = false;         ///< Whether sorting the face, as seen from outside the simplex, is an odd permutation.

  /// A total order, so that the result does not depend on the order of filling.
  friend bool operator<(const FaceRecord& a, const FaceRecord& b) {
    return std::tie(a.others, a.simplex, a.corner) < std::tie(b.others, b.simplex, b.corner);
  }
};

template <int D>
struct Buckets {
  std::vector<std::uint64_t> offsets;  ///< [n_vertices + 1]
  std::vector<FaceRecord<D>> records;
};

template <int D>
Buckets<D> fill_buckets(const Mesh<D>& mesh) {
  Buckets<D> buckets;
  buckets.offsets.assign(mesh.points.size() + 1, 0);
  // The smallest vertex of the face opposite to corner i is the smallest of all but i.
  const auto smallest_vertices = [](const std::array<VertexId, D + 1>& corners) {
    std::array<VertexId, D + 1> smallest;
    for (int i = 0; i <= D; ++i) {
      const auto face = boundary_face<D>(corners, i);
      smallest[static_cast<std::size_t>(i)] = *std::min_element(face.begin(), face.end());
    }
    return smallest;
  };
  for (const auto& corners : mesh.simplex_vertices)
    for (const VertexId v : smallest_vertices(corners)) ++buckets.offsets[v.value() + 1];
  for (std::size_t v = 0; v < mesh.points.size(); ++v) buckets.offsets[v + 1] += buckets.offsets[v];

  buckets.records.resize(buckets.offsets.back());
  std::vector<std::uint64_t> next(buckets.offsets.begin(), buckets.offsets.end() - 1);
  for (const SimplexId s : ids(mesh.simplex_vertices)) {
    for (int i = 0; i <= D; ++i) {
      auto face = boundary_face<D>(mesh.simplex_vertices[s], i);
      FaceRecord<D> record;
      record.odd = sort_vertices(face);
      std::copy(face.begin() + 1, face.end(), record.others.begin());
      record.simplex = s;
      record.corner = static_cast<std::uint8_t>(i);
      buckets.records[next[face[0].value()]++] = record;
    }
  }
  return buckets;
}

template <int D>
std::string face_name(VertexId smallest, const FaceRecord<D>& record) {
  if constexpr (D == 2)
    return fmt::format("edge ({}, {})", smallest.value(), record.others[0].value());
  else
    return fmt::format("face ({}, {}, {})", smallest.value(), record.others[0].value(), record.others[1].value());
}

/// Says what is wrong in the bucket of vertex v, in which something is.
template <int D>
[[noreturn]] void throw_bucket_fault(const Mesh<D>& mesh, VertexId v, std::span<const FaceRecord<D>> bucket) {
  Fault fault;
  fault.position.assign(mesh.points[v].coord.begin(), mesh.points[v].coord.end());
  for (std::size_t k = 0; k + 1 < bucket.size(); ++k) {
    const auto same = [&](std::size_t m) { return m < bucket.size() && bucket[m].others == bucket[k].others; };
    if (same(k + 2)) {
      fault.id = "mesh.nonmanifold";
      fault.message =
          fmt::format("simplices {}, {} and {} (counted from 0) share the {}", bucket[k].simplex.value(),
                      bucket[k + 1].simplex.value(), bucket[k + 2].simplex.value(), face_name<D>(v, bucket[k]));
      fault.fix = "remove duplicate or overlapping simplices";
      throw InputError(fault);
    }
    if (same(k + 1) && bucket[k].odd == bucket[k + 1].odd) {
      fault.id = "mesh.overlapping_simplices";
      fault.message = fmt::format("simplices {} and {} (counted from 0) lie on the same side of their common {}",
                                  bucket[k].simplex.value(), bucket[k + 1].simplex.value(), face_name<D>(v, bucket[k]));
      fault.fix = "remove one of them, or correct the coordinates";
      throw InputError(fault);
    }
  }
  throw InternalError(Fault{.id = "internal.neighbors", .message = "no fault in a faulty bucket"});
}

}  // namespace

template <int D>
void build_neighbors(Mesh<D>& mesh) {
  mesh.simplex_neighbors.clear();
  mesh.simplex_neighbors.resize(mesh.simplex_vertices.size());
  Buckets<D> buckets = fill_buckets(mesh);
  const auto bucket_of = [&](std::size_t v) {
    return std::span<FaceRecord<D>>(buckets.records.data() + buckets.offsets[v],
                                    buckets.records.data() + buckets.offsets[v + 1]);
  };

  std::atomic<std::size_t> first_fault = mesh.points.size();
  parallel_for(mesh.points.size(), [&](std::size_t v) {
    const auto bucket = bucket_of(v);
    std::sort(bucket.begin(), bucket.end());
    for (std::size_t k = 0; k + 1 < bucket.size(); ++k) {
      const FaceRecord<D>&a = bucket[k], &b = bucket[k + 1];
      if (a.others != b.others) continue;
      const bool third = k + 2 < bucket.size() && bucket[k + 2].others == a.others;
      if (third || a.odd == b.odd) {
        for (std::size_t seen = first_fault; v < seen && !first_fault.compare_exchange_weak(seen, v);) continue;
        return;
      }
      mesh.simplex_neighbors[a.simplex][a.corner] = b.simplex;
      mesh.simplex_neighbors[b.simplex][b.corner] = a.simplex;
      ++k;
    }
  });
  if (first_fault < mesh.points.size())
    throw_bucket_fault<D>(mesh, VertexId(first_fault.load()), bucket_of(first_fault));
}

template void build_neighbors<2>(Mesh<2>&);
template void build_neighbors<3>(Mesh<3>&);

}  // namespace voropack
