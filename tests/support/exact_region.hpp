// Rays, lines and regions of light space in whole numbers of any length: what the exact oracle and
// the checks against it compute with.
//
// A ray is three numbers up to a positive factor, a line (a plane through the light) three numbers
// up to any factor but zero; both are kept divided by their greatest common divisor, so equal means
// equal numbers, and nothing grows: a corner is the crossing of two lines, however often its part
// was cut.
//
// A region (a set of rays, up to what has no area) is kept as its boundary: for every line, the
// points at which the boundary on it begins and ends, with how often. Edges between two parts
// cancel, whatever their T-junctions. So two partitions cover the same points equally often iff
// their boundaries are equal, number by number. That says more than equal areas, and no sum of
// fractions is needed to say it.
#pragma once

#include <gmpxx.h>

#include <array>
#include <span>
#include <vector>

namespace shadowcut::testing {

using Int = mpz_class;
using Rational = mpq_class;
using Triple = std::array<Int, 3>;  // of a ray or a line

int sign_of_dot(const Triple& a, const Triple& b);
Int dot(const Triple& a, const Triple& b);
Triple cross(const Triple& a, const Triple& b);
bool is_zero(const Triple& a);
Triple negated(const Triple& a);
// without the common divisor; the sense stays
Triple reduced(Triple a);
// the same for both senses: the first number that is not zero is positive
Triple as_line(Triple a);
// sign of det(a, b, c): positive for a left turn as the light sees it
int turn(const Triple& a, const Triple& b, const Triple& c);

// A convex cone of rays that is not flat. Counter-clockwise seen from the light; may have straight
// corners, none twice.
struct Part {
  std::vector<Triple> corners;
  std::vector<Triple> lines;  // from each corner to the next; positive inside
};

Part part_of(std::vector<Triple> corners);

// Cuts a part along a line, whose positive side goes to `inside`. A side that holds nothing but
// points of the line comes out empty.
void cut(const Part& in, const Triple& line, Part& inside, Part& outside);

// The parts without `hole`. A part that does not overlap it stays whole.
std::vector<Part> without(const std::vector<Part>& parts, const Part& hole);

// Whether the corners run counter-clockwise around a convex cone that is not flat, once. Straight
// corners may be; none twice in a row.
bool is_convex(std::span<const Triple> corners);

class Region {
 public:
  // the boundary on `line` begins (negative) or ends (positive) at `point` so many times
  struct Term {
    Triple line, point;
    int count;
    friend bool operator==(const Term&, const Term&) = default;
  };

  // Any ring of rays of one open half-space, counter-clockwise where it is to be added and
  // clockwise where it is to be taken off.
  void add(std::span<const Triple> ring);
  void add(const Part& part);
  void add(const Region& other);
  void settle();  // after the last add(), before anything below

  bool empty() const { return terms_.empty(); }
  std::span<const Term> terms() const { return terms_; }  // in the order of lines, then points
  friend bool operator==(const Region&, const Region&) = default;

 private:
  void add_edge(const Triple& line, const Triple& from, const Triple& to);
  std::vector<Term> terms_;
};

}  // namespace shadowcut::testing
