//! Addresses that the server answers.

mod sets;
mod weld;

use std::sync::Arc;
use std::time::Duration;

use axum::body::Bytes;
use axum::extract::{DefaultBodyLimit, Path, Query, State};
use axum::http::StatusCode;
use axum::http::header::{CONTENT_DISPOSITION, CONTENT_SECURITY_POLICY, CONTENT_TYPE, HeaderName};
use axum::response::{Html, IntoResponse, Response};
use axum::routing::{get, post, put};
use axum::{Json, Router};
use files::input::{self, MOST_TEXT_BYTES};
use serde::Deserialize;
use serde_json::{Value, json};

use crate::bench::{Bench, PAGE_FILE, Stage, Task};
use crate::drop::{Draft, TrialPlace};
use crate::error::Refusal;
use crate::home::Home;
use crate::next_trial::archive;
use crate::pages;
use crate::part::{Line, PictureData, PictureRequest, drawn, motion, probed, region, section};
use crate::place::Kind;

/// Longest wait for a change; then the request is answered and the page asks again.
const PATIENCE: Duration = Duration::from_secs(20);
/// Greatest size of a dropped file [bytes].
const MOST_DROPPED_BYTES: usize = 1 << 30;
/// Content security policy of a report: it runs its own script and loads nothing.
const REPORT_POLICY: &str = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; \
                             img-src data:; sandbox allow-scripts";

type Answer<T> = Result<T, Refusal>;
type Of = State<Arc<Home>>;

/// Builds the router of all addresses.
pub(crate) fn all(home: Arc<Home>) -> Router {
    Router::new()
        .route("/", get(home_page))
        .route("/place/{id}", get(place_file))
        .route("/place/{id}/next-trial.zip", get(next_trial))
        .route("/asset/{name}", get(asset))
        .route("/bench/{id}", get(bench_page))
        .route("/bench/{id}/state", get(state))
        .route("/bench/{id}/task", post(task))
        .route("/bench/{id}/formula", get(formula))
        .route("/bench/{id}/stage/{number}/sections", get(sections))
        .route("/bench/{id}/stage/{number}/report.html", get(report))
        .route("/bench/{id}/replay.sh", get(replay))
        .route("/bench/{id}/frame", get(frame))
        .route("/bench/{id}/probe", get(probe))
        .route("/bench/{id}/section", get(cut))
        .route("/bench/{id}/region", get(conditions))
        .route("/bench/{id}/motion", get(way))
        .merge(weld::routes())
        .merge(sets::routes())
        .route("/drop/begin", post(drop_begin))
        .route("/drop/file", put(drop_file).layer(DefaultBodyLimit::max(MOST_DROPPED_BYTES)))
        .route("/drop/draft", post(drop_draft))
        .route("/drop/save", post(drop_save))
        .with_state(home)
}

/// Runs work that takes long on a thread for blocking work.
async fn blocking<R: Send + 'static>(work: impl FnOnce() -> R + Send + 'static) -> R {
    match tokio::task::spawn_blocking(work).await {
        Ok(done) => done,
        Err(panic) => std::panic::resume_unwind(panic.into_panic()),
    }
}

async fn bench_of(home: Arc<Home>, id: String) -> Answer<Arc<Bench>> {
    blocking(move || home.bench(&id)).await
}

async fn home_page(State(home): Of) -> Html<String> {
    Html(blocking(move || pages::home(&home).into_string()).await)
}

/// Serves the page of a result or the picture of an asset, as its command wrote it.
async fn place_file(State(home): Of, Path(id): Path<String>) -> Answer<Response> {
    let read = move || {
        let place = home.place(&id)?;
        let file = Home::shown_file(&place);
        let bytes = input::read(&file, MOST_TEXT_BYTES).map_err(|error| Refusal::missing(error.to_string()))?;
        Ok(if place.kind == Kind::Asset { picture(bytes) } else { document(bytes) })
    };
    blocking(read).await
}

async fn next_trial(State(home): Of, Path(id): Path<String>) -> Answer<Response> {
    let packed = blocking(move || archive(&home.place(&id)?.path)).await?;
    let name = (CONTENT_DISPOSITION, "attachment; filename=\"next-trial.zip\"");
    Ok(([(CONTENT_TYPE, "application/zip"), name], packed).into_response())
}

fn document(html: impl IntoResponse) -> Response {
    ([(CONTENT_TYPE, "text/html; charset=utf-8"), (CONTENT_SECURITY_POLICY, REPORT_POLICY)], html).into_response()
}

fn picture(png: Vec<u8>) -> Response {
    ([(CONTENT_TYPE, "image/png")], png).into_response()
}

async fn asset(Path(name): Path<String>) -> Answer<Response> {
    let (kind, text) = pages::asset(&name).ok_or_else(|| Refusal::missing("no such file"))?;
    Ok(([(CONTENT_TYPE, kind)], text).into_response())
}

async fn bench_page(State(home): Of, Path(id): Path<String>) -> Answer<Html<String>> {
    let bench = bench_of(home, id).await?;
    Ok(Html(pages::bench(&bench.place).into_string()))
}

/// Version of the state that the page has already.
#[derive(Deserialize)]
struct Known {
    since: u64,
}

async fn state(State(home): Of, Path(id): Path<String>, Query(known): Query<Known>) -> Answer<Json<Value>> {
    let bench = bench_of(home.clone(), id.clone()).await?;
    let shared = &bench.shared;
    // A wait that times out is answered too, and the page asks again; a page that knows nothing is answered at once.
    let _late = tokio::time::timeout(PATIENCE, shared.later_than(known.since)).await;
    if shared.read(|state| state.is_closed()) {
        home.forget(&id);
    }
    Ok(Json(shared.read(|state| state.to_json(shared.version()))))
}

async fn task(State(home): Of, Path(id): Path<String>, Json(task): Json<Task>) -> Answer<StatusCode> {
    bench_of(home, id).await?.take(task)?;
    Ok(StatusCode::ACCEPTED)
}

/// A formula, possibly incomplete.
#[derive(Deserialize)]
struct Typed {
    line: String,
}

async fn formula(State(home): Of, Path(id): Path<String>, Query(typed): Query<Typed>) -> Answer<Json<Value>> {
    let bench = bench_of(home, id).await?;
    let reader = bench.shared.read(|state| state.reader());
    let reader = reader.ok_or_else(|| Refusal::early("the measurements are still being read"))?;
    Ok(Json(match reader.check(&typed.line) {
        Ok(unknowns) => json!({ "unknowns": unknowns }),
        Err(words) => json!({ "fault": words }),
    }))
}

async fn stage_of(home: Arc<Home>, id: String, number: usize) -> Answer<(Arc<Bench>, Arc<Stage>)> {
    let bench = bench_of(home, id).await?;
    let stage = bench.shared.read(|state| state.stage(number));
    Ok((bench, stage.ok_or_else(|| Refusal::missing(format!("there is no model {number}")))?))
}

async fn sections(State(home): Of, Path((id, number)): Path<(String, usize)>) -> Answer<Json<Value>> {
    let (_, stage) = stage_of(home, id, number).await?;
    Ok(Json(json!(stage.sections)))
}

async fn report(State(home): Of, Path((id, number)): Path<(String, usize)>) -> Answer<Response> {
    let (bench, _) = stage_of(home, id, number).await?;
    let file = bench.out.join(number.to_string()).join(PAGE_FILE);
    let page = blocking(move || input::read_text(&file, MOST_TEXT_BYTES)).await;
    Ok(document(page.map_err(|error| Refusal::missing(error.to_string()))?))
}

/// Serves the command lines that make every model again without the page.
async fn replay(State(home): Of, Path(id): Path<String>) -> Answer<Response> {
    let bench = bench_of(home, id).await?;
    let text = bench.shared.read(|state| state.replay());
    let kind = (CONTENT_TYPE, "text/x-shellscript; charset=utf-8");
    Ok(([kind, (CONTENT_DISPOSITION, "attachment; filename=\"replay.sh\"")], text).into_response())
}

/// Collects the data for pictures: the scans, and a model, by default the current one.
async fn looked_at(home: Arc<Home>, id: String, model: Option<usize>) -> Answer<PictureData> {
    let studio = home.studio.clone();
    let bench = bench_of(home, id).await?;
    bench.shared.read(|state| {
        let surfaces = state.surfaces().ok_or_else(|| Refusal::early("there are no surfaces to look at yet"))?;
        let stage = model.map_or_else(|| state.current(), |number| state.stage(number));
        Ok(PictureData { surfaces, live: stage.and_then(|stage| stage.live()), studio })
    })
}

async fn frame(State(home): Of, Path(id): Path<String>, Query(asked): Query<PictureRequest>) -> Answer<Response> {
    let looked = looked_at(home, id, asked.model).await?;
    let (png, legend) = blocking(move || drawn(&looked, &asked)).await?;
    // Header values are ASCII: other characters are escaped as in JSON.
    let legend: String = legend.to_string().chars().map(escaped).collect();
    Ok(([(HeaderName::from_static("x-legend"), legend)], picture(png)).into_response())
}

fn escaped(letter: char) -> String {
    if letter.is_ascii() { letter.to_string() } else { format!("\\u{:04x}", letter as u32) }
}

/// Pixel: column from the left, row from the top.
#[derive(Deserialize)]
struct Pixel {
    x: usize,
    y: usize,
}

async fn probe(
    State(home): Of,
    Path(id): Path<String>,
    Query(asked): Query<PictureRequest>,
    Query(Pixel { x, y }): Query<Pixel>,
) -> Answer<Json<Value>> {
    let looked = looked_at(home, id, asked.model).await?;
    Ok(Json(blocking(move || probed(&looked, &asked, (x, y))).await?))
}

async fn cut(
    State(home): Of,
    Path(id): Path<String>,
    Query(asked): Query<PictureRequest>,
    Query(line): Query<Line>,
) -> Answer<Json<Value>> {
    let looked = looked_at(home, id, asked.model).await?;
    Ok(Json(blocking(move || section(&looked, &asked, &line)).await?))
}

async fn conditions(
    State(home): Of,
    Path(id): Path<String>,
    Query(asked): Query<PictureRequest>,
    Query(corners): Query<Line>,
) -> Answer<Json<Value>> {
    let looked = looked_at(home, id, asked.model).await?;
    Ok(Json(region(&looked, &asked, &corners)?))
}

async fn way(State(home): Of, Path(id): Path<String>, Query(asked): Query<PictureRequest>) -> Answer<Json<Value>> {
    let looked = looked_at(home, id, asked.model).await?;
    Ok(Json(motion(&looked, &asked)?))
}

async fn drop_begin(State(home): Of, Query(place): Query<TrialPlace>) -> Answer<StatusCode> {
    blocking(move || place.begin(home.folder())).await?;
    Ok(StatusCode::CREATED)
}

/// Name of a dropped file.
#[derive(Deserialize)]
struct Dropped {
    file: String,
}

async fn drop_file(
    State(home): Of,
    Query(place): Query<TrialPlace>,
    Query(Dropped { file }): Query<Dropped>,
    bytes: Bytes,
) -> Answer<StatusCode> {
    blocking(move || place.keep(home.folder(), &file, &bytes)).await?;
    Ok(StatusCode::CREATED)
}

async fn drop_draft(State(home): Of, Query(place): Query<TrialPlace>) -> Answer<Json<Draft>> {
    Ok(Json(blocking(move || place.draft(home.folder())).await?))
}

/// Text of a `trial.toml`.
#[derive(Deserialize)]
struct Corrected {
    text: String,
}

async fn drop_save(
    State(home): Of,
    Query(place): Query<TrialPlace>,
    Json(Corrected { text }): Json<Corrected>,
) -> Answer<Json<Value>> {
    let save = move || {
        let (kept, findings) = place.save(home.folder(), &text)?;
        Ok(json!({ "address": home.address_of(&kept), "findings": findings }))
    };
    Ok(Json(blocking(save).await?))
}
