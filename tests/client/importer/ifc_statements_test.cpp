// Statements, their arguments, and ends that lead nowhere.
#include "client/importer/ifc_statements.h"

#include <gtest/gtest.h>

namespace sightline::client::importer {
namespace {

TEST(IfcStatements, ArgumentsArePartedAtCommas) {
  const Statements statements("#1= IFCA ('a,(;''b',(#2,#3), 4.);\n#2=IFCB((1.,2.));\n#3=IFCC();");
  const Statement* const first = statements.find("#1");
  ASSERT_NE(first, nullptr);
  EXPECT_EQ(first->type, "IFCA");
  EXPECT_EQ(argument(*first, 0), "'a,(;''b'");
  EXPECT_EQ(argument(*first, 1), "(#2,#3)");
  EXPECT_EQ(argument(*first, 2), "4.");
  EXPECT_EQ(argument(*first, 3), "");
  EXPECT_TRUE(statements.each_of("(#2,#3)", [](const Statement&) { return true; }));
  EXPECT_FALSE(statements.each_of("(#2,#9)", [](const Statement&) { return true; }));
  EXPECT_FALSE(statements.each_of("()", [](const Statement&) { return true; }));
  EXPECT_EQ(numbers_of("(1.,2.5E1)"), (std::array<double, 3>{1, 25, 0}));
}

TEST(IfcStatements, LooseEndsAreThoseThatAreThereTwiceOrNot) {
  EXPECT_TRUE(Statements("#1=IFCA(#2,'\n#3, a');\n#2=IFCB($);").loose_ends().empty());
  EXPECT_EQ(Statements("#1=IFCA(#2);").loose_ends(), (std::vector<std::uint64_t>{2}));
  EXPECT_EQ(Statements("#1=IFCA($);\n#1=IFCA($);").loose_ends(), (std::vector<std::uint64_t>{1}));
  EXPECT_EQ(Statements("#1=IFCA('b);\n#2 = IFCB('c');\n#3=IFCC('');").loose_ends(),
            (std::vector<std::uint64_t>{2, 3}))
      << "a string that is not closed";
  EXPECT_EQ(Statements("ENDSEC;\nb',#7);\n#15=IFCB('c');").loose_ends(),
            (std::vector<std::uint64_t>{15}))
      << "the end of a file twice";
}

}  // namespace
}  // namespace sightline::client::importer
