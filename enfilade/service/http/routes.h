/// \file  The routes of the API, one function per group. Exceptions of handlers (HttpError,
/// detail::Refusal, InvalidInput) become responses: see error_response().
#pragma once
#include <filesystem>
#include <memory>

#include "enfilade/service/collecting/collections.h"
#include "enfilade/service/http/context.h"
#include "enfilade/service/http/router.h"

namespace enfilade::service::http {

/// Scans (graphs, faces, plans), splits and episodes.
void add_browsing_routes(Router& router);
/// Continuous navigation: meshes and floors of buildings, continuous episodes.
void add_roaming_routes(Router& router, const std::shared_ptr<const Site>& site);
/// Sessions of the arena: episodes stepped call by call.
void add_playing_routes(Router& router, const std::shared_ptr<const Site>& site,
                        store::Database& db);
/// Runs of the arena, shown step by step. \param runs their folder; empty: none
/// \throws FileError if it is no folder
void add_replay_routes(Router& router, const std::shared_ptr<const Site>& site,
                       const std::filesystem::path& runs);
/// Teams, and logging in to the pages.
void add_account_routes(Router& router);
/// Phases, submissions, leaderboards. \param most_bytes of a results file
void add_evaluation_routes(Router& router, std::size_t most_bytes);
/// For organisers. \param most_bytes of a new collection
void add_collection_routes(Router& router, std::size_t most_bytes);
/// For reviewers and organisers.
void add_review_routes(Router& router);
/// For workers.
void add_work_routes(Router& router);
/// Health, metrics and the API's description.
void add_operation_routes(Router& router);

/// A built page or asset of the web client. \throws HttpError 404
Response page(Context& context, const Request& request);
bool is_page(std::string_view path);  ///< whether page() has that page
/// Gives an error the form of a page, for people, if a browser sent the request. Scripts and the
/// API's clients get JSON.
void show_to_people(const Request& request, Response& error);

/// The collection that {collection} of the path names.
/// \throws Refusal kNotFound for an unknown collection
collecting::Collection collection_of(Context& context, const Request& request);
/// The number that {task} of the path is. \throws HttpError 404 if it is not a number
std::int64_t task_of(const Request& request);

/// A submitted task with its history and any steps.
/// \pre the client is a reviewer or an organiser
/// \throws Refusal kNotFound if no submitted task has this number
Response work_response(Context& context, const Request& request, std::int64_t task);

}  // namespace enfilade::service::http
