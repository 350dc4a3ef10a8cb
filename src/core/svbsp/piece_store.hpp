// The pieces and entries of a cell's tree, and the corners of the pieces.
#pragma once

#include <span>
#include <vector>

#include "predicates/cone.hpp"
#include "support/free_list.hpp"
#include "svbsp/local_lines.hpp"
#include "svbsp/nodes.hpp"

namespace shadowcut {

class PieceStore {
 public:
  std::span<const Piece> pieces() const { return pieces_; }    // free ones among them
  std::span<const Entry> entries() const { return entries_; }  // likewise
  Piece& operator[](PieceId id) {
    SHADOWCUT_ASSERT(id.value() < pieces_.size());
    return pieces_[id.value()];
  }
  const Piece& operator[](PieceId id) const {
    SHADOWCUT_ASSERT(id.value() < pieces_.size());
    return pieces_[id.value()];
  }
  Entry& entry(EntryId id) {
    SHADOWCUT_ASSERT(id.value() < entries_.size());
    return entries_[id.value()];
  }
  const Entry& entry(EntryId id) const {
    SHADOWCUT_ASSERT(id.value() < entries_.size());
    return entries_[id.value()];
  }
  std::size_t piece_count() const { return pieces_.size() - free_pieces_.size(); }
  std::size_t entry_count() const { return entries_.size() - free_entries_.size(); }
  std::span<const ConeCorner> corners(const Piece& p) const {
    SHADOWCUT_ASSERT(p.first_corner + p.corner_count <= corners_.size());
    return std::span(corners_).subspan(p.first_corner, p.corner_count);
  }
  std::span<const ConeCorner> corners(PieceId id) const { return corners((*this)[id]); }
  std::span<ConeCorner> corners(PieceId id) {
    const Piece& p = (*this)[id];
    return std::span(corners_).subspan(p.first_corner, p.corner_count);
  }

  void clear();
  // All pieces go; the entries stay, and are empty.
  void clear_pieces();
  void reserve(std::size_t facets);
  std::uint64_t bytes() const;

  EntryId add_entry(FacetId facet);
  void release_entry(EntryId entry);
  // Adds a piece to its entry's list. It is in no list of a node or a leaf yet.
  PieceId store(const Cone& cone, Piece::Kind kind, std::uint32_t at, LocalLines& lines);
  // Takes a piece out of its entry's list. It has been taken out of its place.
  void release(PieceId piece, LocalLines& lines);
  // Gives a piece another outline.
  void replace_corners(PieceId piece, std::span<const ConeCorner> corners, LocalLines& lines);
  // Gives a piece's edges on a line another line.
  void rename_edges(PieceId piece, LineId line, LineId name, bool bounded, LocalLines& lines);

 private:
  void set_corners(Piece& piece, std::span<const ConeCorner> corners, LocalLines& lines);
  void release_corners(const Piece& piece, LocalLines& lines);

  std::vector<Piece> pieces_;
  std::vector<Entry> entries_;
  std::vector<ConeCorner> corners_;
  RangeList free_corners_;
  FreeList<PieceId> free_pieces_;
  FreeList<EntryId> free_entries_;
};

}  // namespace shadowcut
