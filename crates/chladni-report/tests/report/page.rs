//! Pages: they load nothing else, and foreign text stays text.

use crate::inputs::{input, rendering, simulated, small, ALL_FORMATS};
use chladni_frf::{Checksum, Finding, Reason, Source, Trust};
use chladni_report::{charts, figures, gallery, html, studio_html, ReportInput};

/// Largest size of the page of the demonstration panel.
const MAX_PAGE_BYTES: usize = 8_000_000;

#[test]
fn the_page_needs_no_network_and_runs_no_script_but_its_own() {
    let rendering = rendering(&small().truth);
    let page = html(&input(&small().truth, Some(&small().frf), &rendering)).unwrap();
    // the namespace of SVG elements is not loaded
    let page = page.replace("http://www.w3.org/2000/svg", "");
    for outside in [
        "http://", "https://", " src=", "@import", "url(http", "<link", "<iframe", "fetch(",
    ] {
        assert!(!page.contains(outside), "{outside}");
    }
    assert!(
        page.contains("default-src 'none'")
            && page.contains("script-src 'sha256-")
            && page.contains("connect-src 'none'")
    );
    assert_eq!(page.matches("<script>").count(), 1);
}

#[test]
fn a_gallery_shows_its_figures_without_a_script() {
    let all = figures(&ReportInput {
        model: Some(&small().truth),
        ..Default::default()
    })
    .unwrap();
    let page = gallery("Charts <1>", "made & measured", &all[..3]);
    assert_eq!(
        (
            page.matches("<svg").count(),
            page.matches("<section").count()
        ),
        (3, 3)
    );
    assert!(page.contains("<h1>Charts &lt;1&gt;</h1>") && page.contains("made &amp; measured"));
    assert!(!page.contains("module_page"));
}

#[test]
fn the_studio_asks_its_own_server_only() {
    let page = studio_html("a <b>", 7);
    assert!(
        page.contains("connect-src 'self'")
            && page.contains("fetch(`/api/${path}`")
            && page.contains(r#"{"page":7,"#)
            && page.contains("a &lt;b&gt;")
    );
}

#[test]
fn foreign_text_cannot_become_markup() {
    const EVIL: &str = "</script><script>alert(1)</script>\"'&";
    let mut model = small().truth.clone();
    model.source = vec![Source {
        file: EVIL.into(),
        checksum: Checksum::Sha256(EVIL.into()),
    }];
    (model.method, model.quality.path) = (EVIL.into(), Some(EVIL.into()));
    model.quality.findings = vec![Finding::from(EVIL.to_owned())];
    (model.modes[0].trust, model.modes[0].reasons) =
        (Trust::Weak, vec![Reason::new(EVIL, EVIL)].into());
    let mut rendering = rendering(&small().truth);
    (rendering.weights.scene, rendering.weights.method) = (EVIL.into(), EVIL.into());
    rendering.weights.findings = vec![Finding::from(EVIL.to_owned())].into();
    let mut input = input(&model, None, &rendering);
    (input.title, input.findings) = (EVIL.into(), vec![Finding::from(EVIL.to_owned())]);
    let page = html(&input).unwrap();
    assert_eq!(
        page.matches("<script").count(),
        2,
        "the data and the page's own script"
    );
    assert_eq!(page.matches("</script>").count(), 2);
    assert!(page.contains("<title>&lt;/script&gt;&lt;script&gt;alert(1)"));
}

#[test]
fn measured_frfs_of_another_structure_are_refused() {
    let mut other = small().frf.clone();
    other.responses.iter_mut().for_each(|dof| dof.node += 1000);
    let error = html(&ReportInput {
        model: Some(&small().truth),
        measured: Some(&other),
        ..Default::default()
    })
    .unwrap_err();
    assert!(
        error.to_string().contains("no DOF pair of the model"),
        "{error}"
    );
}

#[test]
fn the_same_input_gives_the_same_bytes() {
    let rendering = rendering(&small().truth);
    let whole = input(&small().truth, Some(&small().frf), &rendering);
    assert!(html(&whole).unwrap() == html(&whole).unwrap());
    let scene_alone = ReportInput {
        model: None,
        measured: None,
        ..whole
    };
    assert!(
        charts(&scene_alone, ALL_FORMATS).unwrap() == charts(&scene_alone, ALL_FORMATS).unwrap()
    );
}

#[test]
fn the_page_of_the_demonstration_panel_stays_small() {
    let simulation = simulated("[plate]\n");
    let rendering = rendering(&simulation.truth);
    let page = html(&input(&simulation.truth, Some(&simulation.frf), &rendering)).unwrap();
    assert!(page.len() < MAX_PAGE_BYTES, "{} bytes", page.len());
}
