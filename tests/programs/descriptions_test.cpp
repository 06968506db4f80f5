// Man pages and completions of a program whose texts are as awkward as texts can be.
#include <gtest/gtest.h>

#include "common/completions.h"
#include "common/man_page.h"
#include "common/option_table.h"

#include <CLI/CLI.hpp>

namespace vcd {
namespace {

using testing::Test;

struct Descriptions : Test {
  CLI::App app{"Eats \\ and 'quotes': .dots\n.TH as well", "vc-odd"};
  std::string text, name;
  std::vector<std::string> list;
  double number = 0;

  Descriptions() {
    app.add_option("-o,--out-file", text, ".begins with a dot, [brackets], a:colon and it's quoted")->type_name("PATH");
    app.add_option("--storage", name, "'begins with a quote")
        ->check(CLI::IsMember({"raw", "ship"}).description(""))
        ->type_name("raw|ship");
    app.add_option("--views", list, "Several")->delimiter(',')->type_name("near|far");
    app.add_option("--share", number, "A share")->check(CLI::Range(0.5, 2.0));
    app.add_option("--hidden", text, "Not for users")->group("");
    app.add_option("files", list, "What to eat")->required()->type_name("SIDECAR|none...");
    app.fallthrough();
    app.add_subcommand("sleep", "Rests")->add_option("place", text, "Where")->type_name("DIR");
    app.footer("Exit codes:\n  0  ok\n.5  odd");
  }
};

TEST_F(Descriptions, TableReadsTypeNames) {
  const CommandEntry table = option_table(app);
  ASSERT_EQ(table.options.size(), 5u);  // with --help
  const OptionEntry& out = table.options[1];
  EXPECT_EQ(out.names, (std::vector<std::string>{"-o", "--out-file"}));
  EXPECT_EQ(out.value.files, Files::any);
  EXPECT_EQ(table.options[2].value.words, (std::vector<std::string>{"raw", "ship"}));
  EXPECT_TRUE(table.options[3].value.comma_list && table.options[3].repeated);
  EXPECT_EQ(table.options[4].value.limits, "0.5 to 2");
  ASSERT_EQ(table.positionals.size(), 1u);
  EXPECT_EQ(table.positionals[0].value.files, Files::sidecars);
  EXPECT_EQ(table.positionals[0].value.words, std::vector<std::string>{"none"});
  EXPECT_TRUE(table.positionals[0].required && table.positionals[0].repeated);
  ASSERT_EQ(table.subcommands.size(), 1u);
  EXPECT_EQ(options_after(table, table.subcommands[0]).size(), 5u);  // one --help, not two
}

TEST_F(Descriptions, ManPageShowsTextsAsTheyAre) {
  const std::string page = man_page(option_table(app));
  EXPECT_NE(page.find(".SH NAME\nvc\\-odd \\- eats \\(rs and \\(aqquotes\\(aq\n"), std::string::npos) << page;
  EXPECT_NE(page.find("Eats \\(rs and \\(aqquotes\\(aq: .dots .TH as well\n"), std::string::npos) << page;
  EXPECT_NE(page.find("\\fB\\-o\\fR, \\fB\\-\\-out\\-file\\fR \\fIPATH\\fR\n\\&.begins with"), std::string::npos)
      << page;
  EXPECT_NE(page.find("\\fBraw\\fR|\\fBship\\fR\n\\(aqbegins"), std::string::npos) << page;
  EXPECT_NE(page.find("\\fBnear\\fR|\\fBfar\\fR[,...]\n"), std::string::npos) << page;
  EXPECT_NE(page.find("A share\n.br\nAccepted: 0.5 to 2.\n"), std::string::npos) << page;
  EXPECT_NE(page.find(".SH \"EXIT CODES\"\n.nf\n  0  ok\n\\&.5  odd\n.fi\n"), std::string::npos) << page;
  EXPECT_EQ(page.find("hidden"), std::string::npos);
}

TEST_F(Descriptions, CompletionsQuoteTexts) {
  const CommandEntry table = option_table(app);
  const std::string zsh = zsh_completion(table);
  EXPECT_NE(zsh.find("'(-o --out-file)--out-file=[.begins with a dot, \\[brackets\\], a\\:colon and it'\\''s "
                     "quoted]:PATH:_files'"),
            std::string::npos)
      << zsh;
  EXPECT_NE(zsh.find(":near|far:_values -s , value near far'"), std::string::npos) << zsh;
  const std::string fish = fish_completion(table);
  EXPECT_NE(fish.find("-s o -l out-file -r -F -d '.begins with a dot, [brackets], a:colon and it\\'s quoted'\n"),
            std::string::npos)
      << fish;
  const std::string bash = bash_completion(table);
  EXPECT_NE(bash.find("'sleep|--storage|raw ship'\n"), std::string::npos) << bash;
  EXPECT_NE(bash.find("'|--views|, near far'\n"), std::string::npos) << bash;
  EXPECT_NE(bash.find("'|+|none / *.vcd'\n"), std::string::npos) << bash;
  for (const std::string& script : {zsh, fish, bash}) EXPECT_EQ(script.find("hidden"), std::string::npos) << script;
}

}  // namespace
}  // namespace vcd
