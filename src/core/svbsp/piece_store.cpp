#include "svbsp/piece_store.hpp"

#include <algorithm>

namespace shadowcut {

void PieceStore::clear() {
  pieces_.clear(), entries_.clear(), corners_.clear();
  free_corners_.clear();
  free_pieces_.clear(), free_entries_.clear();
}

void PieceStore::clear_pieces() {
  pieces_.clear(), corners_.clear();
  free_corners_.clear();
  free_pieces_.clear();
  for (Entry& e : entries_) e.first = PieceId(), e.pieces = 0;
}

// Generous figures: pages that are never written cost nothing, moving a vector does.
void PieceStore::reserve(std::size_t facets) {
  pieces_.reserve(facets * 8);
  entries_.reserve(facets);
  corners_.reserve(facets * 36);
}

std::uint64_t PieceStore::bytes() const {
  return pieces_.size() * sizeof(Piece) + entries_.size() * sizeof(Entry) +
         corners_.size() * sizeof(ConeCorner);
}

EntryId PieceStore::add_entry(FacetId facet) {
  SHADOWCUT_ASSERT(facet.valid());
  EntryId id;
  if (free_entries_.empty()) {
    id = EntryId(entries_.size());
    entries_.emplace_back();
  } else {
    id = free_entries_.take();
  }
  entry(id) = {facet, PieceId(), 0, {}};
  return id;
}

void PieceStore::release_entry(EntryId id) {
  SHADOWCUT_ASSERT(entry(id).facet.valid() && !entry(id).first.valid());
  entry(id).facet = FacetId();
  free_entries_.give_back(id);
}

PieceId PieceStore::store(const Cone& cone, Piece::Kind kind, std::uint32_t at, LocalLines& lines) {
  PieceId id;
  if (free_pieces_.empty()) {
    id = PieceId(pieces_.size());
    pieces_.emplace_back();
  } else {
    id = free_pieces_.take();
  }
  Entry& e = entry(cone.entry);
  SHADOWCUT_ASSERT(e.facet == cone.facet);
  Piece& piece = (*this)[id];
  piece = {cone.facet, 0,          0,       cone.error, at,  PieceId(),
           PieceId(),  cone.entry, e.first, PieceId(),  kind};
  if (e.first.valid()) (*this)[e.first].before = id;
  e.first = id;
  ++e.pieces;
  set_corners(piece, cone.span(), lines);
  SHADOWCUT_ASSERT(e.first == id && piece.entry == cone.entry);
  return id;
}

void PieceStore::release(PieceId id, LocalLines& lines) {
  Piece& p = (*this)[id];
  SHADOWCUT_ASSERT(p.kind != Piece::Kind::free);
  Entry& e = entry(p.entry);
  (p.before.valid() ? (*this)[p.before].after : e.first) = p.after;
  if (p.after.valid()) (*this)[p.after].before = p.before;
  SHADOWCUT_ASSERT(e.pieces > 0);
  --e.pieces;
  release_corners(p, lines);
  p.kind = Piece::Kind::free;
  free_pieces_.give_back(id);
}

void PieceStore::replace_corners(PieceId id, std::span<const ConeCorner> corners,
                                 LocalLines& lines) {
  Piece& p = (*this)[id];
  release_corners(p, lines);
  set_corners(p, corners, lines);
}

void PieceStore::rename_edges(PieceId id, LineId line, LineId name, bool bounded,
                              LocalLines& lines) {
  SHADOWCUT_ASSERT((*this)[id].kind != Piece::Kind::free && name.valid());
  for (ConeCorner& c : corners(id)) {
    if (c.edge.line() != line) continue;
    lines.count_use(line, false);
    lines.count_use(name, true);
    c.edge = EdgeRef(name, c.edge.negative());
    c.edge.set_bounded(bounded);
  }
}

void PieceStore::set_corners(Piece& p, std::span<const ConeCorner> corners, LocalLines& lines) {
  SHADOWCUT_ASSERT(!corners.empty());
  p.corner_count = static_cast<std::uint32_t>(corners.size());
  p.first_corner = free_corners_.take(corners_, p.corner_count);
  std::copy(corners.begin(), corners.end(), corners_.begin() + p.first_corner);
  for (const ConeCorner& c : corners) lines.count_use(c.edge.line(), true);
}

void PieceStore::release_corners(const Piece& p, LocalLines& lines) {
  for (const ConeCorner& c : corners(p)) lines.count_use(c.edge.line(), false);
  free_corners_.give_back(p.first_corner, p.corner_count);
}

}  // namespace shadowcut
