// See exact_region.hpp.
#include "exact_region.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

namespace shadowcut::testing {

Int dot(const Triple& a, const Triple& b) {
  Int sum;
  mpz_mul(sum.get_mpz_t(), a[0].get_mpz_t(), b[0].get_mpz_t());
  mpz_addmul(sum.get_mpz_t(), a[1].get_mpz_t(), b[1].get_mpz_t());
  mpz_addmul(sum.get_mpz_t(), a[2].get_mpz_t(), b[2].get_mpz_t());
  return sum;
}

int sign_of_dot(const Triple& a, const Triple& b) { return sgn(dot(a, b)); }

Triple cross(const Triple& a, const Triple& b) {
  Triple c;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    mpz_mul(c[i].get_mpz_t(), a[j].get_mpz_t(), b[k].get_mpz_t());
    mpz_submul(c[i].get_mpz_t(), a[k].get_mpz_t(), b[j].get_mpz_t());
  }
  return c;
}

bool is_zero(const Triple& a) { return sgn(a[0]) == 0 && sgn(a[1]) == 0 && sgn(a[2]) == 0; }

Triple negated(const Triple& a) { return {-a[0], -a[1], -a[2]}; }

Triple reduced(Triple a) {
  Int divisor;
  mpz_gcd(divisor.get_mpz_t(), a[0].get_mpz_t(), a[1].get_mpz_t());
  mpz_gcd(divisor.get_mpz_t(), divisor.get_mpz_t(), a[2].get_mpz_t());
  if (divisor > 1) {
    for (Int& x : a) mpz_divexact(x.get_mpz_t(), x.get_mpz_t(), divisor.get_mpz_t());
  }
  return a;
}

Triple as_line(Triple a) {
  const auto first = std::find_if(a.begin(), a.end(), [](const Int& x) { return sgn(x) != 0; });
  if (first != a.end() && sgn(*first) < 0) {
    for (Int& x : a) mpz_neg(x.get_mpz_t(), x.get_mpz_t());
  }
  return reduced(std::move(a));
}

int turn(const Triple& a, const Triple& b, const Triple& c) { return sign_of_dot(cross(a, b), c); }

Part part_of(std::vector<Triple> corners) {
  Part part;
  for (std::size_t i = 0; i < corners.size(); ++i)
    part.lines.push_back(reduced(cross(corners[i], corners[(i + 1) % corners.size()])));
  part.corners = std::move(corners);
  return part;
}

// The corner on edge i is line_i x line, turned so that it is a positive combination of the edge's
// ends: (c_i x c_j) x n = c_j (n.c_i) - c_i (n.c_j).
void cut(const Part& in, const Triple& line, Part& inside, Part& outside) {
  inside = {}, outside = {};
  const std::size_t size = in.corners.size();
  std::vector<int> at;
  for (const Triple& c : in.corners) at.push_back(sign_of_dot(line, c));
  if (std::count(at.begin(), at.end(), -1) == 0) inside = in;
  else if (std::count(at.begin(), at.end(), 1) == 0) outside = in;
  if (!inside.corners.empty() || !outside.corners.empty()) return;
  const Triple opposite = negated(line);
  const auto put = [](Part& part, const Triple& corner, const Triple& to_next) {
    part.corners.push_back(corner);
    part.lines.push_back(to_next);
  };
  for (std::size_t i = 0; i < size; ++i) {
    const int here = at[i], next = at[(i + 1) % size];
    const Triple& edge = in.lines[i];
    if (here >= 0) put(inside, in.corners[i], here == 0 && next < 0 ? line : edge);
    if (here <= 0) put(outside, in.corners[i], here == 0 && next > 0 ? opposite : edge);
    if (here * next >= 0) continue;
    Triple corner = cross(edge, line);
    if (here < 0) corner = negated(corner);
    corner = reduced(std::move(corner));
    put(inside, corner, here > 0 ? line : edge);
    put(outside, corner, here < 0 ? opposite : edge);
  }
}

std::vector<Part> without(const std::vector<Part>& parts, const Part& hole) {
  std::vector<Part> out, fresh;
  Part rest, inside, outside;
  for (const Part& part : parts) {
    fresh.clear();
    rest = part;
    for (std::size_t i = 0; i < hole.lines.size() && !rest.corners.empty(); ++i) {
      cut(rest, hole.lines[i], inside, outside);
      if (!outside.corners.empty()) fresh.push_back(std::move(outside));
      rest = std::move(inside);
    }
    if (rest.corners.empty()) out.push_back(part);
    else std::move(fresh.begin(), fresh.end(), std::back_inserter(out));
  }
  return out;
}

// Every turn is to the left or straight on; and seen from the first corner, too, all others come in
// order, so it goes round once.
bool is_convex(std::span<const Triple> corners) {
  const std::size_t size = corners.size();
  if (size < 3) return false;
  std::vector<Triple> lines;
  for (std::size_t i = 0; i < size; ++i)
    lines.push_back(cross(corners[i], corners[(i + 1) % size]));
  bool flat = true;
  for (std::size_t i = 0; i < size; ++i) {
    const int left = sign_of_dot(lines[i], corners[(i + 2) % size]),
              fan = sign_of_dot(lines[i], corners[0]);
    if (is_zero(lines[i]) || left < 0 || fan < 0) return false;
    // it turns back
    if (left == 0 && sign_of_dot(lines[i], lines[(i + 1) % size]) <= 0) return false;
    flat = flat && fan == 0;
  }
  return !flat;
}

void Region::add_edge(const Triple& line, const Triple& from, const Triple& to) {
  terms_.push_back({line, from, -1});
  terms_.push_back({line, to, 1});
}

void Region::add(std::span<const Triple> ring) {
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Triple &from = ring[i], &to = ring[(i + 1) % ring.size()];
    const Triple line = cross(from, to);
    if (!is_zero(line)) add_edge(as_line(line), from, to);
  }
}

void Region::add(const Part& part) {
  for (std::size_t i = 0; i < part.corners.size(); ++i)
    add_edge(as_line(part.lines[i]), part.corners[i], part.corners[(i + 1) % part.corners.size()]);
}

void Region::add(const Region& other) {
  terms_.insert(terms_.end(), other.terms_.begin(), other.terms_.end());
}

void Region::settle() {
  std::sort(terms_.begin(), terms_.end(), [](const Term& a, const Term& b) {
    return std::tie(a.line, a.point) < std::tie(b.line, b.point);
  });
  std::vector<Term> kept;
  for (Term& t : terms_) {
    if (!kept.empty() && kept.back().line == t.line && kept.back().point == t.point)
      kept.back().count += t.count;
    else {
      if (!kept.empty() && kept.back().count == 0) kept.pop_back();
      kept.push_back(std::move(t));
    }
  }
  if (!kept.empty() && kept.back().count == 0) kept.pop_back();
  terms_ = std::move(kept);
}

}  // namespace shadowcut::testing
