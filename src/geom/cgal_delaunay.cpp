#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Spatial_sort_traits_adapter_2.h>
#include <CGAL/Spatial_sort_traits_adapter_3.h>
#include <CGAL/Triangulation_cell_base_with_info_3.h>
#include <CGAL/Triangulation_face_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>
#include <CGAL/hilbert_sort.h>
#include <CGAL/property_map.h>

#include <algorithm>
#include <numeric>

#include "geom/delaunay_kernel.h"
#include "voropack/error.h"

namespace voropack {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Index = std::uint32_t;

/// What differs between CGAL's two- and three-dimensional triangulations.
template <int K>
struct Cgal;

template <>
struct Cgal<2> {
  using Vertex = CGAL::Triangulation_vertex_base_with_info_2<Index, Kernel>;
  using Face = CGAL::Triangulation_face_base_with_info_2<Index, Kernel>;
  using Triangulation = CGAL::Delaunay_triangulation_2<Kernel, CGAL::Triangulation_data_structure_2<Vertex, Face>>;
  using Point = Kernel::Point_2;
  using Cell_handle = Triangulation::Face_handle;
  using Vertex_handle = Triangulation::Vertex_handle;
  static Point point(const Vec<2>& p) { return {p[0], p[1]}; }
  static void conflicts(const Triangulation& t, const Point& p, Cell_handle start, std::vector<Cell_handle>& out) {
    t.get_conflicts(p, std::back_inserter(out), start);
  }
  static Cell_handle locate(const Triangulation& t, const Point& p, Cell_handle start) { return t.locate(p, start); }
  static Vertex_handle insert(Triangulation& t, const Point& p, Cell_handle start) { return t.insert(p, start); }
  static void incident(const Triangulation& t, Vertex_handle v, std::vector<Cell_handle>& out) {
    auto begin = t.incident_faces(v);
    auto circulator = begin;
    do {
      out.push_back(circulator);
    } while (++circulator != begin);
  }
  static void all(const Triangulation& t, std::vector<Cell_handle>& out) {
    for (auto f : t.all_face_handles()) out.push_back(f);
  }
  static Cell_handle any(Vertex_handle v) { return v->face(); }
  template <class Map>
  static void sort(std::vector<std::size_t>& order, Map map) {
    CGAL::hilbert_sort(order.begin(), order.end(), CGAL::Spatial_sort_traits_adapter_2<Kernel, Map>(map));
  }
};

template <>
struct Cgal<3> {
  using Vertex = CGAL::Triangulation_vertex_base_with_info_3<Index, Kernel>;
  using Cell =
      CGAL::Triangulation_cell_base_with_info_3<Index, Kernel, CGAL::Delaunay_triangulation_cell_base_3<Kernel>>;
  using Triangulation = CGAL::Delaunay_triangulation_3<Kernel, CGAL::Triangulation_data_structure_3<Vertex, Cell>>;
  using Point = Kernel::Point_3;
  using Cell_handle = Triangulation::Cell_handle;
  using Vertex_handle = Triangulation::Vertex_handle;
  static Point point(const Vec<3>& p) { return {p[0], p[1], p[2]}; }
  static void conflicts(const Triangulation& t, const Point& p, Cell_handle start, std::vector<Cell_handle>& out) {
    t.find_conflicts(p, start, CGAL::Emptyset_iterator(), std::back_inserter(out));
  }
  static Cell_handle locate(const Triangulation& t, const Point& p, Cell_handle start) { return t.locate(p, start); }
  static Vertex_handle insert(Triangulation& t, const Point& p, Cell_handle start) { return t.insert(p, start); }
  static void incident(const Triangulation& t, Vertex_handle v, std::vector<Cell_handle>& out) {
    t.incident_cells(v, std::back_inserter(out));
  }
  static void all(const Triangulation& t, std::vector<Cell_handle>& out) {
    for (auto c : t.all_cell_handles()) out.push_back(c);
  }
  static Cell_handle any(Vertex_handle v) { return v->cell(); }
  template <class Map>
  static void sort(std::vector<std::size_t>& order, Map map) {
    CGAL::hilbert_sort(order.begin(), order.end(), CGAL::Spatial_sort_traits_adapter_3<Kernel, Map>(map));
  }
};

}  // namespace

template <int K>
struct CgalDelaunay<K>::Impl {
  using C = Cgal<K>;
  typename C::Triangulation triangulation;
  std::vector<typename C::Vertex_handle> vertices;
  std::vector<typename C::Cell_handle> cells;  ///< By slot; default-constructed handle for an empty slot.
  std::vector<Slot> free_slots;
  std::vector<Slot> created;

  void fill_slot(typename C::Cell_handle cell) {
    Slot slot;
    if (free_slots.empty()) {
      slot = static_cast<Slot>(cells.size());
      cells.push_back(cell);
    } else {
      slot = free_slots.back();
      free_slots.pop_back();
      cells[slot] = cell;
    }
    cell->info() = slot;
    created.push_back(slot);
  }

  void insert_first(const std::vector<typename C::Point>& points, const std::vector<std::size_t>& order) {
    typename C::Cell_handle hint{};
    for (const std::size_t i : order) {
      const auto n_before = triangulation.number_of_vertices();
      auto v = triangulation.insert(points[i], hint);
      if (triangulation.number_of_vertices() == n_before) report_duplicate(static_cast<Index>(i));
      vertices[i] = v;
      hint = C::any(v);
    }
    if (triangulation.dimension() < K)
      throw InputError(Fault{.id = "delaunay.degenerate",
                             .message = "all points to triangulate lie in one hyperplane",
                             .fix = "give points that span the space"});
    for (Index i = 0; i < points.size(); ++i) vertices[i]->info() = i;
    std::vector<typename C::Cell_handle> all;
    C::all(triangulation, all);
    for (auto cell : all) fill_slot(cell);
  }

  void insert_one(const typename C::Point& p, Index id, typename C::Cell_handle start) {
    std::vector<typename C::Cell_handle> conflicts, incident;
    start = C::locate(triangulation, p, start);
    C::conflicts(triangulation, p, start, conflicts);
    if (conflicts.empty()) report_duplicate(id);
    for (auto cell : conflicts) {
      free_slots.push_back(cell->info());
      cells[cell->info()] = {};
    }
    auto v = C::insert(triangulation, p, start);
    v->info() = id;
    vertices[id] = v;
    C::incident(triangulation, v, incident);
    for (auto cell : incident) fill_slot(cell);
  }

  [[noreturn]] static void report_duplicate(Index id) {
    throw InputError(Fault{.id = "delaunay.duplicate_points",
                           .message = "point " + std::to_string(id) + " (counted from 0) lies exactly on another one",
                           .fix = "remove one of the two"});
  }
};

template <int K>
CgalDelaunay<K>::CgalDelaunay() : impl_(std::make_unique<Impl>()) {}
template <int K>
CgalDelaunay<K>::~CgalDelaunay() = default;
template <int K>
CgalDelaunay<K>::CgalDelaunay(CgalDelaunay&&) noexcept = default;
template <int K>
CgalDelaunay<K>& CgalDelaunay<K>::operator=(CgalDelaunay&&) noexcept = default;

template <int K>
void CgalDelaunay<K>::insert(std::span<const Vec<K>> points, std::span<const std::uint32_t> hints) {
  using C = Cgal<K>;
  const auto first = static_cast<Index>(impl_->vertices.size());
  std::vector<typename C::Point> cgal_points;
  cgal_points.reserve(points.size());
  for (const Vec<K>& p : points) cgal_points.push_back(C::point(p));
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  C::sort(order, CGAL::make_property_map(cgal_points));
  impl_->vertices.resize(first + points.size());
  if (first == 0) {
    impl_->insert_first(cgal_points, order);
    return;
  }
  auto last = impl_->vertices[0];
  for (const std::size_t i : order) {
    auto near = hints.empty() || hints[i] == kNoHint ? last : impl_->vertices[hints[i]];
    impl_->insert_one(cgal_points[i], static_cast<Index>(first + i), C::any(near));
    last = impl_->vertices[first + i];
  }
}

template <int K>
std::uint32_t CgalDelaunay<K>::n_vertices() const {
  return static_cast<std::uint32_t>(impl_->vertices.size());
}

template <int K>
std::uint32_t CgalDelaunay<K>::n_slots() const {
  return static_cast<std::uint32_t>(impl_->cells.size());
}

template <int K>
bool CgalDelaunay<K>::is_alive(Slot slot) const {
  return impl_->cells[slot] != typename Cgal<K>::Cell_handle{};
}

template <int K>
bool CgalDelaunay<K>::is_finite(Slot slot) const {
  return is_alive(slot) && !impl_->triangulation.is_infinite(impl_->cells[slot]);
}

template <int K>
typename CgalDelaunay<K>::Corners CgalDelaunay<K>::corners(Slot slot) const {
  Corners result;
  for (int i = 0; i <= K; ++i) {
    auto v = impl_->cells[slot]->vertex(i);
    result[static_cast<std::size_t>(i)] = impl_->triangulation.is_infinite(v) ? kInfiniteVertex : v->info();
  }
  return result;
}

template <int K>
typename CgalDelaunay<K>::Corners CgalDelaunay<K>::neighbors(Slot slot) const {
  Corners result;
  for (int i = 0; i <= K; ++i) result[static_cast<std::size_t>(i)] = impl_->cells[slot]->neighbor(i)->info();
  return result;
}

template <int K>
typename CgalDelaunay<K>::Slot CgalDelaunay<K>::slot_of_vertex(std::uint32_t vertex) const {
  return Cgal<K>::any(impl_->vertices[vertex])->info();
}

template <int K>
std::vector<typename CgalDelaunay<K>::Slot> CgalDelaunay<K>::take_created() {
  std::vector<Slot> created;
  created.swap(impl_->created);
  std::sort(created.begin(), created.end());
  created.erase(std::unique(created.begin(), created.end()), created.end());
  std::erase_if(created, [&](Slot s) { return !is_alive(s); });
  return created;
}

template class CgalDelaunay<2>;
template class CgalDelaunay<3>;

}  // namespace voropack
