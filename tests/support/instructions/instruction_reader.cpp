#include "tests/support/instructions/instruction_reader.h"

#include <algorithm>
#include <map>
#include <sstream>

#include "tests/support/instructions/instruction_words.h"

namespace enfilade::homes::instructions::testing {
namespace {

Words words_of(const std::string& text) {
  std::istringstream in(text);
  Words words;
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

bool is_one(const std::string& word, std::initializer_list<const char*> list) {
  return std::ranges::any_of(list, [&](const char* w) { return word == w; });
}

bool is_determiner(const std::string& w) {
  return is_one(w, {"the", "a", "an", "your", "another"});
}

// Words that end a noun phrase.
bool ends_phrase(const std::string& w) {
  return is_one(
      w, {",",       ".",        "and",     "then",    "on",     "to",   "of",    "into", "that",
          "is",      "by",       "in",      "behind",  "ahead",  "with", "at",    "from", "through",
          "for",     "via",      "using",   "until",   "once",   "up",   "next",  "near", "beside",
          "forward", "straight", "leading", "towards", "toward", "are",  "along", "out",  "down",
          "between", "the",      "your",    "as",      "when",   "past", "stands"});
}

// A piece of a clause: a noun phrase or a single word.
struct Piece {
  enum class Kind : std::uint8_t { kWord, kThing, kRoom, kDoor, kStairs, kSide, kOther };
  Kind kind = Kind::kWord;
  std::string text;  // the word; the head noun of a phrase
  Words adjectives;
  ThingNamed thing;
  std::set<std::size_t> rooms;
  bool another = false;
  bool used = false;
};

using Clause = std::vector<Piece>;
using Kind = Claim::Kind;

// Finds noun phrases.
class Chunker {
 public:
  explicit Chunker(const Home& home) : home_(home) {}

  std::vector<Piece> chunk(const Words& words) const {
    std::vector<Piece> pieces;
    for (std::size_t i = 0; i < words.size();) {
      if (!is_determiner(words[i])) {
        pieces.push_back({Piece::Kind::kWord, words[i], {}, {}, {}, false, false});
        ++i;
        continue;
      }
      // The first word may be one that ends others: "the next room".
      std::size_t end = std::min(i + 2, words.size());
      const bool alone = is_one(words[end - 1], {"stop", "halt"});
      while (!alone && end < words.size() &&
             (!ends_phrase(words[end]) || joins_of(words, i + 1, end))) {
        ++end;
      }
      pieces.push_back(phrase(words, i, end));
      i = end;
    }
    return pieces;
  }

 private:
  // "chest of drawers" and "flight of stairs" are one.
  static bool joins_of(const Words& words, std::size_t begin, std::size_t at) {
    return words[at] == "of" && at > begin && at + 1 < words.size() &&
           is_one(words[at - 1], {"chest", "flight", "bowl", "bunch", "rack", "pair", "pile"}) &&
           is_one(words[at + 1],
                  {"drawers", "stairs", "fruit", "flowers", "clothes", "shoes", "books"});
  }

  Piece phrase(const Words& words, std::size_t begin, std::size_t end) const {
    Piece piece;
    piece.another = words[begin] == "another";
    for (std::size_t from = begin + 1; from < end; ++from) {
      std::string head = words[from];
      for (std::size_t k = from + 1; k < end; ++k) head += " " + words[k];
      piece.text = head;
      piece.adjectives.assign(words.begin() + static_cast<std::ptrdiff_t>(begin) + 1,
                              words.begin() + static_cast<std::ptrdiff_t>(from));
      if (fill(piece, head)) return piece;
    }
    piece.kind = Piece::Kind::kOther;
    for (auto a = piece.adjectives.rbegin(); a != piece.adjectives.rend(); ++a) {
      piece.text = *a + " " + piece.text;
    }
    piece.adjectives.clear();
    return piece;
  }

  bool fill(Piece& piece, const std::string& head) const {
    if (is_one(head, {"left", "right", "left turn", "right turn"})) {
      piece.kind = Piece::Kind::kSide;
      piece.text = head.starts_with("left") ? "left" : "right";
      return true;
    }
    if (is_one(head, {"door", "doorway", "archway", "arch", "opening", "front door",
                      "entrance door", "threshold"})) {
      piece.kind = Piece::Kind::kDoor;
      return true;
    }
    if (is_one(head, {"stairs", "steps", "staircase", "flight of stairs"})) {
      piece.kind = Piece::Kind::kStairs;
      for (std::size_t i = 0; i < home_.plan.rooms.size(); ++i) {
        if (home_.plan.rooms[i].type == 's') piece.rooms.insert(i);
      }
      return true;
    }
    // To people, "the toilet" is the thing.
    if (head == "toilet" && fill_thing(piece, head)) return true;
    // "The room" may be any.
    piece.rooms = head == "room" && piece.adjectives.empty() ? all_rooms() : rooms_called(head);
    if (!piece.rooms.empty()) {
      piece.kind = Piece::Kind::kRoom;
      piece.another = piece.another || std::ranges::any_of(piece.adjectives, [](const auto& a) {
                        return is_one(a, {"other", "different", "next"});
                      });
      return true;
    }
    return fill_thing(piece, head);
  }

  std::set<std::size_t> all_rooms() const {
    std::set<std::size_t> all;
    for (std::size_t i = 0; i < home_.plan.rooms.size(); ++i) all.insert(i);
    return all;
  }
  std::set<std::size_t> rooms_called(const std::string& name) const {
    const auto also = other_rooms().find(name);
    std::set<std::size_t> found;
    for (std::size_t i = 0; i < home_.plan.rooms.size(); ++i) {
      const std::string own = lower(home_.plan.rooms[i].name);
      if (own == name || (also != other_rooms().end() && std::ranges::count(also->second, own))) {
        found.insert(i);
      }
    }
    return found;
  }

  bool fill_thing(Piece& piece, const std::string& head) const {
    const auto also = other_words().find(head);
    bool known = false;
    for (std::size_t i = 0; i < home_.things.size(); ++i) {
      const HomeThing& t = home_.things[i];
      const std::string own = lower(t.noun);
      if (own != head && !(also != other_words().end() && std::ranges::count(also->second, own))) {
        continue;
      }
      known = true;
      const Words looks = words_of(lower(t.colour + " " + t.material));
      // All of a colour's words or none: a dark blue chair is not "the dark chair".
      const bool fits = std::ranges::all_of(piece.adjectives, [&](const std::string& a) {
        const auto colour = other_colours().find(a);
        const Words stands_for = colour == other_colours().end() ? Words{a} : colour->second;
        return std::ranges::all_of(stands_for, [&](const std::string& word) {
          return std::ranges::count(looks, word) > 0;
        });
      });
      if (fits) piece.thing.fits.push_back(i);
    }
    if (!known) return false;
    piece.kind = Piece::Kind::kThing;
    piece.thing.words = head;
    for (auto a = piece.adjectives.rbegin(); a != piece.adjectives.rend(); ++a) {
      piece.thing.words = *a + " " + piece.thing.words;
    }
    return true;
  }

  const Home& home_;
};

class Reader {
 public:
  explicit Reader(const Home& home) : home_(home), chunker_(home) {}

  Reading read(const std::string& text) {
    Clause clause;
    bool over = false;
    for (Piece& piece : chunker_.chunk(split_words(text))) {
      check_known(piece);
      if (over) reading_.not_understood.push_back("after the stop: " + piece.text);
      const bool between = std::ranges::any_of(clause, [](const Piece& p) {
        return p.kind == Piece::Kind::kWord && p.text == "between";
      });
      const bool joins = between && noun_count(clause) < 2;
      if (piece.kind == Piece::Kind::kWord && is_one(piece.text, {",", ".", "and", "then"}) &&
          !(piece.text == "and" && joins)) {
        finish(clause);
        clause.clear();
        over = stopping_ && piece.text == ".";
      } else {
        clause.push_back(std::move(piece));
      }
    }
    finish(clause);
    return std::move(reading_);
  }

 private:
  static std::size_t noun_count(const Clause& clause) {
    return static_cast<std::size_t>(std::ranges::count_if(clause, [](const Piece& p) {
      return p.kind == Piece::Kind::kThing || p.kind == Piece::Kind::kRoom;
    }));
  }

  void check_known(const Piece& piece) {
    const bool word = piece.kind == Piece::Kind::kWord;
    if (word && !is_one(piece.text, {",", "."}) && !is_function_word(piece.text)) {
      reading_.not_understood.push_back(piece.text);
    }
    if (piece.kind == Piece::Kind::kOther && !is_plain_phrase(piece.text)) {
      reading_.not_understood.push_back(piece.text);
    }
    if (piece.kind == Piece::Kind::kThing && piece.thing.fits.empty()) {
      reading_.not_understood.push_back("no such thing: " + piece.thing.words);
    }
  }

  static bool has(const Clause& c, std::initializer_list<const char*> list) {
    return std::ranges::any_of(c, [&](const Piece& p) {
      return (p.kind == Piece::Kind::kWord || p.kind == Piece::Kind::kOther) &&
             is_one(p.text, list);
    });
  }
  static std::string word_at(const Clause& c, std::size_t i) {
    return i < c.size() && c[i].kind == Piece::Kind::kWord ? c[i].text : std::string();
  }
  // The words before piece i, back to the noun phrase before it.
  static Words before(const Clause& c, std::size_t i) {
    Words words;
    while (i > 0 && (c[i - 1].kind == Piece::Kind::kWord || c[i - 1].kind == Piece::Kind::kOther)) {
      words.insert(words.begin(), c[--i].text);
    }
    return words;
  }
  static bool any(const Words& words, std::initializer_list<const char*> list) {
    return std::ranges::any_of(words, [&](const std::string& w) { return is_one(w, list); });
  }

  void push(Claim claim) {
    claim.at_stop = stopping_;
    claim.at_start = !moved_ && !stopping_;
    reading_.claims.push_back(std::move(claim));
  }
  Claim& make(Kind kind) {
    Claim claim;
    claim.kind = kind;
    push(std::move(claim));
    return reading_.claims.back();
  }

  void finish(Clause& c) {
    if (c.empty()) return;
    const std::string first = word_at(c, 0);
    const bool stop = (is_one(first, {"stop", "wait", "halt", "stand", "pause", "finish"}) ||
                       (first == "stay" && word_at(c, 1) != "straight") ||
                       (first == "end" && word_at(c, 1) == "up") ||
                       (first == "come" && c.size() > 2 && is_one(c[2].text, {"stop", "halt"})));
    if (stop) {
      stopping_ = true;
      make(Kind::kStop);
    }
    const std::size_t claims = reading_.claims.size();
    if (stopping_) {
      read_place(c);
    } else if (is_view(c)) {
      read_view(c);
    } else if (is_opener(c)) {
      read_opener(c);
    } else {
      read_motion(c);
      if (reading_.claims.size() > claims) moved_ = true;
    }
  }

  static bool is_view(const Clause& c) {
    const std::string first = word_at(c, 0);
    return is_one(first, {"with", "facing", "looking", "starting", "standing", "beginning"});
  }
  static bool is_opener(const Clause& c) {
    const std::string first = word_at(c, 0);
    return is_one(first, {"once", "when", "at"}) || (first == "in" && c.size() == 2);
  }

  static Side side_named(const Piece& p) {
    return p.text == "left" ? Side::kLeft : p.text == "right" ? Side::kRight : Side::kNone;
  }
  static bool is_side(const Clause& c, std::size_t i) {
    if (c[i].kind == Piece::Kind::kSide) return true;
    if (c[i].kind != Piece::Kind::kWord || !is_one(c[i].text, {"left", "right"})) return false;
    const std::string next = word_at(c, i + 1);
    return !(c[i].text == "right" && is_one(next, {"before", "inside", "next"}));
  }

  void read_view(Clause& c) {
    for (std::size_t i = 0; i < c.size(); ++i) {
      if (c[i].kind != Piece::Kind::kThing) continue;
      Claim claim;
      claim.kind = has(c, {"behind", "back"}) ? Kind::kBehind : Kind::kAhead;
      claim.thing = c[i].thing;
      for (std::size_t k = i + 1; k < c.size(); ++k) {
        if (!is_side(c, k)) continue;
        claim.kind = Kind::kBeside;
        claim.side = side_named(c[k]);
      }
      push(claim);
    }
  }

  void read_opener(Clause& c) {
    for (const Piece& p : c) {
      if (p.kind == Piece::Kind::kRoom) make(Kind::kInside).to = p.rooms;
      if (p.text == "upstairs" || p.text == "downstairs") {
        make(Kind::kUpstairs).up = p.text == "upstairs";
      }
      if (is_one(p.text, {"top", "very top", "bottom", "foot"}) && !p.text.empty()) {
        make(Kind::kTop).up = p.text.ends_with("top");
      }
    }
  }

  // After "stop": where.
  void read_place(Clause& c) {
    const bool at_end = has(c, {"end"}) && word_at(c, 0) != "end";
    for (std::size_t i = 0; i < c.size(); ++i) {
      Piece& p = c[i];
      if (p.used) continue;
      const Words words = before(c, i);
      if (p.kind == Piece::Kind::kThing) place_by_thing(c, i, words);
      if (p.kind == Piece::Kind::kDoor) place_by_door(c, i, words);
      if (p.kind == Piece::Kind::kRoom) {
        Claim& claim = make(at_end                                   ? Kind::kEndOf
                            : has(c, {"middle", "center", "centre"}) ? Kind::kMiddle
                                                                     : Kind::kInside);
        claim.to = p.rooms;
      }
      if (p.kind == Piece::Kind::kStairs) place_by_stairs(words);
    }
  }

  void place_by_thing(const Clause& c, std::size_t i, const Words& words) {
    Claim claim;
    claim.kind = Kind::kNear;
    claim.thing = c[i].thing;
    for (std::size_t k = i + 1; k < c.size(); ++k) {
      if (is_side(c, k)) claim.side = side_named(c[k]);
    }
    push(claim);
    if (any(words, {"front", "facing", "before", "opposite", "across"})) {
      claim.kind = Kind::kAhead;
      push(claim);
    }
  }

  void place_by_door(Clause& c, std::size_t i, const Words& words) {
    Claim claim;
    claim.kind =
        any(words, {"in", "on"}) && !any(words, {"front"}) ? Kind::kInDoorway : Kind::kByDoor;
    claim.opening = kind_of_door(c[i]);
    for (std::size_t k = i + 1; k < c.size(); ++k) {
      if (c[k].rooms.empty()) continue;
      (claim.to ? claim.from : claim.to) = c[k].rooms;
      c[k].used = true;
    }
    push(claim);
  }

  void place_by_stairs(const Words& words) {
    if (any(words, {"top", "very top", "head"})) {
      make(Kind::kTop).up = true;
    } else if (any(words, {"bottom", "foot"})) {
      make(Kind::kTop).up = false;
    } else {
      make(any(words, {"on"}) ? Kind::kOnStairs : Kind::kInside);
    }
  }

  static std::optional<OpeningKind> kind_of_door(const Piece& p) {
    if (p.text == "threshold") return std::nullopt;
    if (is_one(p.text, {"archway", "arch", "opening"})) return OpeningKind::kArch;
    if (is_one(p.text, {"front door", "entrance door"})) return OpeningKind::kEntrance;
    return OpeningKind::kDoor;
  }

  static unsigned ordinal(const Piece& p) {
    const char* const names[] = {"", "first", "second", "third", "fourth"};
    for (unsigned n = 1; n < 5; ++n) {
      if (std::ranges::count(p.adjectives, names[n]) > 0) return n;
    }
    return 0;
  }

  void read_motion(Clause& c) {
    if (read_stairs(c)) return;
    read_turn(c);
    read_crossing(c);
    read_things(c);
    read_distance(c);
  }

  bool read_stairs(const Clause& c) {
    const bool flight =
        std::ranges::any_of(c, [](const Piece& p) { return p.kind == Piece::Kind::kStairs; });
    const bool word = has(c, {"upstairs", "downstairs"});
    if (!flight && !word) return false;
    if (!word && !has(c, {"up", "down", "climb", "ascend", "mount", "descend"})) return false;
    Claim& claim = make(Kind::kStairs);
    claim.up = has(c, {"up", "upstairs", "climb", "ascend", "mount"});
    claim.partly = has(c, {"part", "start", "begin"});
    claim.to_end =
        has(c, {"top", "very top", "bottom", "foot", "upper floor", "next floor", "floor above",
                "upper level", "lower floor", "floor below", "lower level", "all", "rest"});
    return true;
  }

  void read_turn(Clause& c) {
    const bool turns =
        has(c, {"turn", "spin", "reverse", "u-turn", "about-face", "complete turn around"});
    const bool round = has(c, {"around", "u-turn", "about-face", "complete turn around",
                               "other way", "way around", "reverse"});
    if (turns && round) {
      make(Kind::kAround);
      return;
    }
    for (std::size_t i = 0; i < c.size(); ++i) {
      if (!is_side(c, i) || belongs_to_noun(c, i)) continue;
      Claim& claim = make(Kind::kTurn);
      claim.side = side_named(c[i]);
      claim.slight = has(c, {"bear", "veer", "angle", "curve", "drift", "slightly", "little", "bit",
                             "gently"}) ||
                     any(c[i].adjectives, {"slight", "little", "bit"});
      claim.sharp = has(c, {"sharp", "sharply"}) || any(c[i].adjectives, {"sharp", "hard"});
      c[i].used = true;
      return;
    }
    if (has(c, {"straight", "forward", "onward", "directly"})) make(Kind::kStraight);
  }

  // "the sofa on your left", "to the left of the sofa"
  static bool belongs_to_noun(const Clause& c, std::size_t i) {
    if (word_at(c, i + 1) == "of") return true;
    for (std::size_t k = 0; k < i; ++k) {
      const auto kind = c[k].kind;
      if (kind == Piece::Kind::kThing || kind == Piece::Kind::kDoor || kind == Piece::Kind::kRoom) {
        return true;
      }
    }
    return false;
  }

  void read_crossing(Clause& c) {
    Claim cross;
    cross.kind = Kind::kCross;
    bool found = false;
    std::size_t noun = c.size();  // the last place or door, for sides
    for (std::size_t i = 0; i < c.size(); ++i) {
      const Words words = before(c, i);
      if (c[i].kind == Piece::Kind::kDoor) {
        cross.by_opening = found = true;
        cross.opening = kind_of_door(c[i]);
        cross.nth = ordinal(c[i]);
        noun = i;
      } else if (c[i].kind == Piece::Kind::kRoom) {
        if (any(words, {"leave", "exit", "from"}) || (any(words, {"out"}) && any(words, {"of"}))) {
          cross.from = c[i].rooms;
          found = true;
        } else if (any(words, {"through", "along", "down", "follow", "end"})) {
          make(has(c, {"end", "all"}) ? Kind::kEndOf : Kind::kInside).to = c[i].rooms;
        } else {
          cross.to = with_mark(c, i);
          cross.another = c[i].another;
          found = true;
        }
        noun = i;
      }
    }
    if (!found) return;
    for (std::size_t i = noun < c.size() ? 0 : c.size(); i < c.size(); ++i) {
      if (is_side(c, i) && !c[i].used && belongs_to_noun(c, i)) cross.side = side_named(c[i]);
    }
    push(cross);
  }

  // "the bedroom with the red rug": bedrooms that have one.
  std::set<std::size_t> with_mark(Clause& c, std::size_t i) const {
    if (word_at(c, i + 1) != "with" || i + 2 >= c.size() || c[i + 2].kind != Piece::Kind::kThing) {
      return c[i].rooms;
    }
    c[i + 2].used = true;
    std::set<std::size_t> rooms;
    for (const std::size_t thing : c[i + 2].thing.fits) {
      if (c[i].rooms.contains(home_.things[thing].room)) rooms.insert(home_.things[thing].room);
    }
    return rooms;
  }

  void read_things(Clause& c) {
    Claim claim;
    std::size_t found = 0;
    for (std::size_t i = 0; i < c.size(); ++i) {
      if (c[i].kind != Piece::Kind::kThing || c[i].used) continue;
      if (++found == 2) {
        claim.second = c[i].thing;
        continue;
      }
      const Words words = before(c, i);
      claim.thing = c[i].thing;
      claim.kind = any(words, {"between"})                                       ? Kind::kBetween
                   : any(words, {"over", "across", "cross", "traverse", "onto"}) ? Kind::kOver
                   : any(words, {"towards", "toward", "direction", "aim", "approach", "for"})
                       ? Kind::kTowards
                       : Kind::kPass;
      for (std::size_t k = 0; k < c.size(); ++k) {
        if (!is_side(c, k) || c[k].used) continue;
        claim.side = side_named(c[k]);
        if (word_at(c, k + 1) == "of") {
          claim.side = claim.side == Side::kLeft ? Side::kRight : Side::kLeft;
        }
      }
    }
    if (found > 0) push(claim);
  }

  void read_distance(const Clause& c) {
    static const std::map<std::string, double> kNumbers{
        {"one", 1},     {"two", 2},     {"three", 3},    {"four", 4},    {"five", 5},
        {"six", 6},     {"seven", 7},   {"eight", 8},    {"nine", 9},    {"ten", 10},
        {"eleven", 11}, {"twelve", 12}, {"fifteen", 15}, {"twenty", 20}, {"thirty", 30}};
    const double unit = has(c, {"feet"}) ? 0.3048 : 1;
    for (const Piece& p : c) {
      const auto number = kNumbers.find(p.text);
      if (number != kNumbers.end()) make(Kind::kWalk).metres = unit * number->second;
      if (is_one(p.text, {"couple", "short way", "little way"})) make(Kind::kWalk).metres = 1.7;
      if (is_one(p.text, {"long way", "distance"})) make(Kind::kWalk).metres = 15;
    }
  }

  const Home& home_;
  Chunker chunker_;
  Reading reading_;
  bool moved_ = false, stopping_ = false;
};

}  // namespace

std::vector<Named> read_names(const Home& home, const std::string& text) {
  std::vector<Named> names;
  std::string before;
  for (const Piece& piece : Chunker(home).chunk(split_words(text))) {
    const bool is_name = piece.kind == Piece::Kind::kThing || piece.kind == Piece::Kind::kRoom;
    if (is_name) names.push_back({before, piece.thing, piece.rooms});
    before = piece.text;
  }
  return names;
}

Reading read_instruction(const Home& home, const std::string& text) {
  return Reader(home).read(text);
}

}  // namespace enfilade::homes::instructions::testing
