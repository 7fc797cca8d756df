//! The report to hand over, its evidence, and what packages and the site are made of.

use crate::code_rules::{files, relative_path, root, text};
use crate::common::program::{command, encspec};
use crate::sample_run;
use encspec::report;
use rstest::rstest;
use std::collections::BTreeSet;
use std::fs;
use testing::Folder;

const XAC77: &str = "model:lika-xac77-profinet/xac7718";

#[test]
fn the_page_has_a_cover_and_says_what_was_not_tested() {
    let mut result = sample_run::everything();
    result.origin.commit = Some("0123456789ab".into());
    result.origin.started = Some("2026-11-28T04:05:06Z".into());
    result.origin.operator = Some("A. <Tester>".into());
    result.origin.suites = vec![("acme-profinet".into(), "ab".repeat(32))];
    result.runs[0].dut.details = vec![("serial number".into(), "4711".into())];
    result.runs[0].cases[1].evidence_sha256 = Some("cd".repeat(32));
    let page = report::html(&result, &|_| report::CaseEvidence::default());
    for part in [
        ", commit 0123456789ab</dd>",
        "<dt>date</dt><dd>2026-11-28T04:05:06Z</dd>",
        "<dt>operator</dt><dd>A. &lt;Tester&gt;</dd>",
        &format!("<dd>acme-profinet, SHA-256 {}</dd>", "ab".repeat(32)),
        "<dt>serial number</dt><dd>4711</dd>",
        "Summary by chapter",
        "<td>3 position</td><td>3</td><td>1 fail, 2 not-run</td>",
        "<td>xfail</td><td>acme-profinet/preset/known</td><td>must</td><td>known failure FW-7: the position is late</td>",
        "<td>1</td><td>stand cannot press the preset button</td><td>acme-profinet/preset/by-hand</td>",
        "<td>2</td><td>no case covers it in this run</td><td>ACME-002, ACME-003</td>",
        &format!("<td>evidence/acme-profinet_single_preset_it_s[row_1].pcapng</td><td>{}</td>", "cd".repeat(32)),
    ] {
        assert!(page.contains(part), "{part}\n{page}");
    }
}

#[test]
fn no_file_name_ends_the_list_of_the_evidence() {
    let mut result = sample_run::everything();
    result.runs[0].cases[1].evidence = Some("a</script><script>alert(1)</script>.pcapng".into());
    let page = report::html(&result, &|_| report::CaseEvidence::default());
    assert!(!page.contains("<script>alert"), "{page}");
}

#[test]
fn evidence_is_verified_by_its_hash() {
    let folder = Folder::new("verify");
    let red = encspec(
        &folder,
        &[
            "run",
            "--dut",
            XAC77,
            "--bug",
            "only-first-preset",
            "--report",
            "html=r.html",
            "--report",
            "json=r.json",
            "preset/",
        ],
    );
    assert_eq!(red.status, Some(1), "{}", red.err);
    let verify = |report: &str| encspec(&folder, &["verify", report]);
    for report in ["r.html", "r.json"] {
        let said = verify(report);
        assert_eq!(said.status, Some(0), "{report}: {}{}", said.out, said.err);
        assert!(said.out.ends_with(" files of evidence, all unchanged.\n"), "{}", said.out);
    }
    let capture = folder.join("encspec-evidence/lika-xac77-profinet_xac7718_preset_second-preset.pcapng");
    let mut octets = fs::read(&capture).expect("the capture");
    *octets.last_mut().expect("an octet") ^= 1;
    fs::write(&capture, octets).expect("the changed capture");
    let changed = verify("r.html");
    assert_eq!(changed.status, Some(1));
    assert!(
        changed.out.contains("changed   encspec-evidence/lika-xac77-profinet_xac7718_preset_second-preset.pcapng"),
        "{}",
        changed.out
    );
    assert!(changed.out.contains("\n1 of "), "{}", changed.out);
    fs::remove_file(&capture).expect("the capture");
    let missing = verify("r.json");
    assert_eq!(missing.status, Some(1));
    assert!(missing.out.contains("missing   encspec-evidence/"), "{}", missing.out);
}

#[rstest]
#[case::pdf("r.pdf", "%PDF-1.4", "a PDF has no list of files")]
#[case::text("r.txt", "Green", "it is no HTML or JSON report of `encspec run`")]
#[case::json("r.json", "{\"runs\": []}", "it is no HTML or JSON report of `encspec run`")]
fn another_file_cannot_be_verified(#[case] name: &str, #[case] content: &str, #[case] says: &str) {
    let folder = Folder::new(&format!("verify-{name}"));
    folder.write(name, content);
    let said = encspec(&folder, &["verify", name]);
    assert_eq!(said.status, Some(2));
    assert!(said.err.contains(says), "{}", said.err);
}

#[test]
fn a_pdf_needs_a_browser_which_is_said_before_the_run() {
    let folder = Folder::new("pdf");
    let arguments = ["run", "--dut", XAC77, "--report", "pdf=r.pdf", "--no-evidence", "preset/second-preset"];
    let without = command(folder.path(), &arguments).env("PATH", folder.path()).output().expect("it runs");
    assert_eq!(without.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&without.stderr).contains("--report pdf needs Chromium or Chrome"));
    assert!(!folder.join("r.pdf").exists());
    let with = encspec(&folder, &arguments);
    let granted = if with.status == Some(2) { Err("there is no Chromium".to_owned()) } else { Ok(()) };
    if !testing::available(granted) {
        return;
    }
    assert_eq!(with.status, Some(0), "{}", with.err);
    let pdf = fs::read(folder.join("r.pdf")).expect("the report");
    assert!(pdf.starts_with(b"%PDF") && pdf.len() > 10_000, "{} bytes", pdf.len());
}

#[test]
fn the_version_has_commit_and_date() {
    let said = encspec(Folder::new("version"), &["--version"]).out;
    let rest = said.strip_prefix(&format!("encspec {}", env!("CARGO_PKG_VERSION"))).expect("the version");
    let git = std::process::Command::new("git")
        .args(["-C", &root().display().to_string(), "log", "-1", "--format=%h %cs", "--abbrev=12"])
        .output();
    // A copy of the sources without a repository has no commit.
    let known = git
        .ok()
        .filter(|output| output.status.success())
        .map(|output| String::from_utf8_lossy(&output.stdout).trim().to_owned());
    match known {
        // The tests may have been built before the last commit.
        Some(known) => assert!(rest.starts_with(" (") && rest.trim_end().len() == known.len() + 3, "{said} {known}"),
        None => assert_eq!(rest, "\n"),
    }
}

#[test]
fn manual_pages_and_completions_follow_the_command_line() {
    let folder = Folder::new("man");
    assert_eq!(encspec(&folder, &["man", "man"]).status, Some(0));
    let page = fs::read_to_string(folder.join("man/encspec-run.1")).expect("the page of run");
    let help = encspec(&folder, &["run", "--help"]).out;
    let options: BTreeSet<&str> = help
        .split_whitespace()
        .filter(|word| word.starts_with("--"))
        .map(|word| word.trim_matches([',', '.', ';', ')', '`']))
        .collect();
    assert!(options.len() > 20, "{options:?}");
    for option in options.iter().filter(|option| option.chars().skip(2).all(|c| c.is_ascii_lowercase() || c == '-')) {
        assert!(page.contains(&option.replace('-', "\\-")), "{option} is not in the manual page");
    }
    for (shell, begin) in [("bash", "_encspec"), ("zsh", "#compdef encspec"), ("fish", "complete -c encspec")] {
        let said = encspec(&folder, &["completions", shell]);
        assert!(said.status == Some(0) && said.out.contains(begin) && said.out.contains("fail-fast"), "{shell}");
    }
    // Neither command is for people.
    let help = encspec(&folder, &["--help"]).out;
    assert!(!help.contains("\n  man ") && !help.contains("\n  completions "), "{help}");
}

/// Each page is on the site, and each link between pages leads to a file and a heading.
#[test]
fn the_site_has_every_page() {
    let pages: BTreeSet<String> = files("docs", "md")
        .iter()
        .map(|path| relative_path(path))
        .filter(|name| !name.ends_with("SUMMARY.md"))
        .collect();
    let summary = text(&root().join("docs/SUMMARY.md"));
    let listed: BTreeSet<String> = links(&summary).map(|link| format!("docs/{link}")).collect();
    assert_eq!(listed, pages);
    let mut wrong = Vec::new();
    for page in pages.iter().map(String::as_str).chain(["README.md", "CHANGELOG.md", "examples/ci/README.md"]) {
        let folder = root().join(page).parent().expect("a folder").to_owned();
        for link in links(&text(&root().join(page)))
            .filter(|link| !link.starts_with("http"))
            .map(str::to_owned)
            .collect::<Vec<_>>()
        {
            let (file, heading) = link.split_once('#').unwrap_or((&link, ""));
            let target = if file.is_empty() { root().join(page) } else { folder.join(file) };
            let is_known = match (target.exists(), heading) {
                (exists, "") => exists,
                (exists, heading) => exists && headings(&text(&target)).contains(heading),
            };
            if !is_known {
                wrong.push(format!("{page}: {link}"));
            }
        }
    }
    assert!(wrong.is_empty(), "links that lead nowhere:\n{}", wrong.join("\n"));
}

/// The targets of the links in Markdown, without those in code.
fn links(text: &str) -> impl Iterator<Item = &str> {
    let mut is_code = false;
    let lines = text.lines().filter(move |line| {
        let is_fence = line.trim_start().starts_with("```");
        is_code ^= is_fence;
        !is_code && !is_fence
    });
    lines.flat_map(|line| line.split("](").skip(1)).filter_map(|rest| rest.split(')').next())
}

/// The headings of a page as anchors, as GitHub and mdBook make them.
fn headings(text: &str) -> BTreeSet<String> {
    let heads = text.lines().filter(|line| line.starts_with('#')).map(|line| line.trim_start_matches('#').trim());
    let anchor = |head: &str| -> String {
        let kept = head
            .to_lowercase()
            .chars()
            .filter(|c| c.is_alphanumeric() || [' ', '-', '_'].contains(c))
            .collect::<String>();
        kept.replace(' ', "-")
    };
    heads.map(anchor).collect()
}
