//! Addresses of the page on which a weld is made.

use std::collections::BTreeMap;
use std::sync::Arc;

use axum::extract::{Path, Query, State};
use axum::http::StatusCode;
use axum::response::{Html, Response};
use axum::routing::{get, post};
use axum::{Json, Router};
use serde::Deserialize;
use serde_json::{Value, json};

use super::{Answer, Known, Of, PATIENCE, blocking, picture};
use crate::drop::fit;
use crate::error::Refusal;
use crate::home::Home;
use crate::pages;
use crate::part::{Shot, Size, Turn, png};
use crate::weld::{Easel, Flags, OpenPart, Order, Outcome};

/// Adds the addresses.
pub(super) fn routes() -> Router<Arc<Home>> {
    Router::new()
        .route("/weld", get(page))
        .route("/weld/parts/{id}/figures", get(figures))
        .route("/weld/parts/{id}/picture", get(frame))
        .route("/weld/run", get(run).post(start))
        .route("/weld/cancel", post(cancel))
}

async fn page(State(home): Of) -> Html<String> {
    Html(blocking(move || pages::weld(&home).into_string()).await)
}

async fn part_of(home: &Arc<Home>, id: String) -> Answer<Arc<OpenPart>> {
    let home = home.clone();
    blocking(move || home.welder.open(&id)).await
}

/// Name of an asset to make.
#[derive(Deserialize)]
struct Named {
    name: String,
}

async fn figures(
    State(home): Of,
    Path(id): Path<String>,
    Query(pairs): Query<Vec<(String, String)>>,
    Query(Named { name }): Query<Named>,
) -> Answer<Json<Value>> {
    let flags = Flags::read(pairs)?;
    let part = part_of(&home, id).await?;
    // A name that is not accepted is refused when the asset is made; the figures do not depend on it.
    let command = fit(&name).map(|name| Order::new(part.file(), &home.folder().join(name), &flags).line());
    let mut found = part.ask(move |easel: &mut Easel<'_>| Ok(easel.figures(&flags))).await?;
    found["command"] = json!(command.as_ref().ok());
    found["nameFault"] = json!(command.err().map(|refusal| refusal.1));
    Ok(Json(found))
}

async fn frame(
    State(home): Of,
    Path(id): Path<String>,
    Query(pairs): Query<Vec<(String, String)>>,
    Query(turn): Query<Turn>,
    Query(size): Query<Size>,
) -> Answer<Response> {
    let flags = Flags::read(pairs)?;
    let part = part_of(&home, id).await?;
    let draw = move |easel: &mut Easel<'_>| easel.picture(&flags, &Shot { turn, size }).map(|drawn| png(&drawn));
    Ok(picture(part.ask(draw).await?))
}

/// An asset to make.
#[derive(Deserialize)]
struct Wanted {
    /// Id of the part.
    part: String,
    /// Name of the asset's folder in the served one.
    name: String,
    /// Flags by their names with hyphens.
    flags: BTreeMap<String, String>,
}

async fn start(State(home): Of, Json(wanted): Json<Wanted>) -> Answer<StatusCode> {
    let flags = Flags::read(wanted.flags)?;
    let out = home.folder().join(fit(&wanted.name)?);
    blocking(move || {
        let part = home.welder.part(&wanted.part)?;
        if out.exists() {
            return Err(Refusal::wrong(format!("{}: this exists; another name is accepted", out.display())));
        }
        home.welder.maker.start(&Order::new(&part, &out, &flags))
    })
    .await?;
    Ok(StatusCode::ACCEPTED)
}

async fn run(State(home): Of, Query(known): Query<Known>) -> Json<Value> {
    // A wait that times out is answered too, and the page asks again.
    let _late = tokio::time::timeout(PATIENCE, home.welder.maker.later_than(known.since)).await;
    let (version, run) = home.welder.maker.state();
    let made = run.clone().filter(|run| run.outcome == Some(Outcome::Made));
    let address = blocking(move || made.and_then(|run| home.address_of_asset(&run.out))).await;
    Json(json!({ "version": version, "run": run, "address": address }))
}

async fn cancel(State(home): Of) -> StatusCode {
    home.welder.maker.cancel();
    StatusCode::ACCEPTED
}
