#include "domain/regions.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

namespace voropack::domain_impl {

namespace {

constexpr const char* kMoveSeed = "move the seed into the interior of a region";

/// The volume of a seed, or a fault.
template <int D>
std::optional<std::uint32_t> volume_of_seed(const Volumes<D>& volumes, const Vec<D>& x, const std::string& name,
                                            FaultList<D>& faults) {
  const auto volume = volumes.locate(x);
  if (!volume) {
    faults.add("seed_on_wall", fmt::format("{} at {} lies on a wall", name, place_text(x)), kMoveSeed, x);
    return std::nullopt;
  }
  if (*volume == Volumes<D>::kOutside) {
    faults.add("seed_outside", fmt::format("{} at {} lies outside of the domain", name, place_text(x)),
               "move the seed into the domain, or remove it", x);
    return std::nullopt;
  }
  return volume;
}

/// What the seeds in one volume ask for.
struct Wishes {
  std::optional<std::size_t> hole_seed, region_seed;
  std::optional<int> id;
  std::optional<double> max_simplex;
};

template <int D>
std::vector<Wishes> collect_wishes(const Complex<D>& complex, const Volumes<D>& volumes, FaultList<D>& faults) {
  const DomainInput<D>& input = *complex.input;
  const Names<D> names(input);
  std::vector<Wishes> wishes(volumes.size());
  for (std::size_t i = 0; i < input.hole_seeds.size(); ++i) {
    const auto volume =
        volume_of_seed(volumes, input.hole_seeds[i], fmt::format("hole seed {}", names.number(i)), faults);
    if (volume) wishes[*volume].hole_seed = i;
  }
  for (std::size_t i = 0; i < input.region_seeds.size(); ++i) {
    const auto& seed = input.region_seeds[i];
    const auto volume = volume_of_seed(volumes, seed.position, fmt::format("region seed {}", names.number(i)), faults);
    if (!volume) continue;
    Wishes& wish = wishes[*volume];
    if (wish.hole_seed)
      faults.add("seed_conflict",
                 fmt::format("region seed {} at {} and hole seed {} at {} lie in the same volume", names.number(i),
                             place_text(seed.position), names.number(*wish.hole_seed),
                             place_text(input.hole_seeds[*wish.hole_seed])),
                 "remove one of them, or separate them by a wall", seed.position);
    if (wish.id && seed.id && *wish.id != *seed.id)
      faults.add(
          "seed_conflict",
          fmt::format(
              "region seeds {} and {} lie in the same volume, but give it the ids {} and {}; the second is at {}",
              names.number(*wish.region_seed), names.number(i), *wish.id, *seed.id, place_text(seed.position)),
          "give both the same id, remove one, or separate them by a wall", seed.position);
    if (!wish.id) wish.id = seed.id;
    if (!wish.region_seed) wish.region_seed = i;
    if (seed.max_measure && *seed.max_measure > 0)
      wish.max_simplex = std::min(wish.max_simplex.value_or(*seed.max_measure), *seed.max_measure);
  }
  return wishes;
}

}  // namespace

template <int D>
RegionTable assign_regions(const Complex<D>& complex, const Volumes<D>& volumes, FaultList<D>& faults) {
  const std::vector<Wishes> wishes = collect_wishes(complex, volumes, faults);
  std::set<int> used;
  for (const Wishes& wish : wishes)
    if (wish.id) used.insert(*wish.id);
  RegionTable table;
  int next = 1;
  for (std::uint32_t volume = 0; volume < volumes.size(); ++volume) {
    const Wishes& wish = wishes[volume];
    if (wish.hole_seed) {
      table.of_volume.push_back(RegionId::none());
      continue;
    }
    if (!wish.id)
      while (used.count(next) > 0) ++next;
    table.of_volume.push_back(table.id.push_back(wish.id ? *wish.id : next++));
    table.measure.push_back(volumes.measure(volume));
    table.max_simplex.push_back(wish.max_simplex);
  }
  return table;
}

namespace {

/// Walls that bound no region, joined where they meet.
template <int D>
class UselessWalls {
 public:
  UselessWalls(const std::vector<Fin>& fins, const Volumes<D>& volumes, const RegionTable& regions, std::size_t n_walls)
      : fins_(fins), useless_(n_walls), walls_fins_(n_walls) {
    for (std::uint32_t w = 0; w < n_walls; ++w)
      useless_[w] = regions.at(volumes.at(w, 0)).is_none() && regions.at(volumes.at(w, 1)).is_none();
    for (std::size_t f = 0; f < fins.size(); ++f) {
      walls_fins_[fins[f].wall].push_back(f);
      if (f == 0 || fins[f - 1].ridge != fins[f].ridge) first_of_ridge_ = f;
      ridge_begin_.push_back(first_of_ridge_);
    }
  }

  struct Cluster {
    std::vector<std::uint32_t> walls;
    std::vector<std::uint32_t> free_ridges;  ///< With one wall only.
    bool touches_region = false;             ///< Some ridge also has a wall that bounds a region.
  };

  std::vector<Cluster> clusters() {
    std::vector<Cluster> all;
    std::vector<char> seen(useless_.size(), 0);
    for (std::uint32_t start = 0; start < useless_.size(); ++start) {
      if (!useless_[start] || seen[start] != 0) continue;
      Cluster cluster;
      std::vector<std::uint32_t> stack = {start};
      seen[start] = 1;
      while (!stack.empty()) {
        const std::uint32_t wall = stack.back();
        stack.pop_back();
        cluster.walls.push_back(wall);
        for (const std::size_t f : walls_fins_[wall]) {
          const std::size_t begin = ridge_begin_[f];
          std::size_t n = 0;
          for (std::size_t g = begin; g < fins_.size() && fins_[g].ridge == fins_[f].ridge; ++g, ++n) {
            const std::uint32_t other = fins_[g].wall;
            if (!useless_[other]) cluster.touches_region = true;
            if (!useless_[other] || seen[other] != 0) continue;
            seen[other] = 1;
            stack.push_back(other);
          }
          if (n == 1) cluster.free_ridges.push_back(fins_[f].ridge);
        }
      }
      std::sort(cluster.walls.begin(), cluster.walls.end());
      std::sort(cluster.free_ridges.begin(), cluster.free_ridges.end());
      all.push_back(std::move(cluster));
    }
    return all;
  }

 private:
  const std::vector<Fin>& fins_;
  std::vector<bool> useless_;
  std::vector<std::vector<std::size_t>> walls_fins_;
  std::vector<std::size_t> ridge_begin_;  ///< For each fin, the first one at its ridge.
  std::size_t first_of_ridge_ = 0;
};

std::string list(const std::vector<std::uint32_t>& items, const std::function<std::string(std::uint32_t)>& name) {
  constexpr std::size_t kShown = 3;
  std::string words;
  for (std::size_t i = 0; i < std::min(items.size(), kShown); ++i) words += (i > 0 ? "; " : "") + name(items[i]);
  if (items.size() > kShown) words += fmt::format("; and {} more", items.size() - kShown);
  return words;
}

template <int D>
Vec<D> middle(const Walls<D>& walls, std::uint32_t wall) {
  for (std::size_t s = 0; s < walls.simplices.size(); ++s)
    if (walls.simplex_wall[s] == wall) {
      Vec<D> x;
      for (const std::uint32_t p : walls.simplices[s]) x += walls.points[p] / static_cast<double>(D);
      return x;
    }
  return {};
}

}  // namespace

template <int D>
void check_walls(const Complex<D>& complex, const Walls<D>& walls, const std::vector<Fin>& fins,
                 const Volumes<D>& volumes, const RegionTable& regions, const WallNames& names, FaultList<D>& faults) {
  const char* wall_word = D == 2 ? "segments" : "facets";
  for (const auto& cluster : UselessWalls<D>(fins, volumes, regions, walls.n_walls).clusters()) {
    if (faults.full()) return;
    const std::uint32_t wall = cluster.walls.front();
    bool at_hole = false;
    for (const std::uint32_t w : cluster.walls)
      for (int side = 0; side < 2; ++side) at_hole = at_hole || volumes.at(w, side) != Volumes<D>::kOutside;
    if (at_hole) {
      faults.add("outside",
                 fmt::format("{} {} bound no region, since hole seeds empty the volumes at them: {}",
                             cluster.walls.size(), wall_word, list(cluster.walls, names.wall)),
                 "remove the hole seeds that are not needed, or these walls", middle(walls, wall));
    } else if (!cluster.free_ridges.empty() && !cluster.touches_region) {
      const std::uint32_t ridge = cluster.free_ridges.front();
      Vec<D> place;
      if constexpr (D == 2)
        place = complex.points[ridge];
      else
        place =
            0.5 * (complex.points[complex.segments[ridge].ends[0]] + complex.points[complex.segments[ridge].ends[1]]);
      faults.add(
          "open_boundary",
          fmt::format("{} {} enclose nothing: {} {} belong to one of them only: {}", cluster.walls.size(), wall_word,
                      cluster.free_ridges.size(), D == 2 ? "points" : "edges", list(cluster.free_ridges, names.ridge)),
          D == 2 ? "close the boundary at these points" : "close the surface at these edges", place);
    } else {
      faults.add("outside",
                 fmt::format("{} {} lie outside of every region: {}", cluster.walls.size(), wall_word,
                             list(cluster.walls, names.wall)),
                 "remove them, or close the boundary around them", middle(walls, wall));
    }
  }
}

template <int D>
RegionId region_of(const Complex<D>&, const Volumes<D>& volumes, const RegionTable& regions, const Vec<D>& x,
                   const std::string& name, FaultList<D>& faults) {
  const auto volume = volumes.locate(x);
  const RegionId region = volume ? regions.at(*volume) : RegionId::none();
  if (!volume)
    faults.add("self_intersection", fmt::format("{} touches a wall at {}", name, place_text(x)),
               "move it away from the wall, or onto it", x);
  else if (region.is_none())
    faults.add("outside",
               fmt::format("{} at {} lies {}", name, place_text(x),
                           *volume == Volumes<D>::kOutside ? "outside of every region" : "in a hole"),
               "remove it, or move it into a region", x);
  return region;
}

template RegionTable assign_regions(const Complex<2>&, const Volumes<2>&, FaultList<2>&);
template RegionTable assign_regions(const Complex<3>&, const Volumes<3>&, FaultList<3>&);
template void check_walls(const Complex<2>&, const Walls<2>&, const std::vector<Fin>&, const Volumes<2>&,
                          const RegionTable&, const WallNames&, FaultList<2>&);
template void check_walls(const Complex<3>&, const Walls<3>&, const std::vector<Fin>&, const Volumes<3>&,
                          const RegionTable&, const WallNames&, FaultList<3>&);
template RegionId region_of(const Complex<2>&, const Volumes<2>&, const RegionTable&, const Vec<2>&, const std::string&,
                            FaultList<2>&);
template RegionId region_of(const Complex<3>&, const Volumes<3>&, const RegionTable&, const Vec<3>&, const std::string&,
                            FaultList<3>&);

}  // namespace voropack::domain_impl
